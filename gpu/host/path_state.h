/// State of the paths in flight, in device memory, and host copies of it for observers.
#pragma once

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "gpu/host/device_memory.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/contract/stage_observer.h"

namespace SCOTTY_DEVICE_NAMESPACE {

struct PathState {
    explicit PathState(MemoryBudget& budget)
        : rays(budget),
          shadow_rays(budget),
          throughput(budget),
          radiance(budget),
          potential(budget),
          pixel(budget),
          sample(budget),
          depth(budget),
          flags(budget),
          path_hits(budget),
          shadow_hits(budget),
          image(budget),
          filtered(budget) {}

    /// Calls f(name, buffer) for every buffer that is indexed by ray id.
    template <class F>
    void for_each_by_ray(F&& f) {
        f("rays", rays);
        f("shadow_rays", shadow_rays);
        f("throughput", throughput);
        f("radiance", radiance);
        f("potential", potential);
        f("pixel", pixel);
        f("sample", sample);
        f("depth", depth);
        f("flags", flags);
        f("path_hits", path_hits);
        f("shadow_hits", shadow_hits);
    }
    void resize(std::uint32_t count) {
        for_each_by_ray([&](const char* name, auto& buffer) { buffer.resize(count, name); });
    }
    void release() {
        for_each_by_ray([](const char*, auto& buffer) { buffer.release(); });
        image.release();
        filtered.release();
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(rays.size()); }
    PathView view() const {
        return {rays.data(),  throughput.data(), radiance.data(), potential.data(),
                pixel.data(), sample.data(),     depth.data(),    flags.data()};
    }

    DeviceMemory<reference::Ray> rays, shadow_rays;
    DeviceMemory<reference::Vec3> throughput, radiance, potential;
    DeviceMemory<std::uint32_t> pixel, sample, depth, flags;
    DeviceMemory<reference::Hit> path_hits, shadow_hits;
    DeviceMemory<reference::Vec3> image, filtered;
};

/// Copies buffers to the host on demand; the views stay valid as long as this lives.
class HostPathState {
 public:
    explicit HostPathState(PathState& device) : device_(device) {}

    reference::BufferView view(const char* wanted) {
        reference::BufferView result;
        const auto copy = [&](const char* name, auto& buffer) {
            if (std::strcmp(name, wanted) == 0) result = copied(name, buffer);
        };
        device_.for_each_by_ray(copy);
        copy("image", device_.image);
        copy("filtered", device_.filtered);
        return result;
    }

 private:
    template <class T>
    reference::BufferView copied(const char* name, const DeviceMemory<T>& buffer) {
        auto host = std::make_shared<std::vector<T>>(download(buffer.data(), buffer.size(), name));
        kept_.push_back(host);
        return reference::buffer_view(name, std::span<const T>(*host),
                                      reference::buffer_info(name).meaning);
    }

    PathState& device_;
    std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
