/// State of the paths in flight, in device memory, and host copies of it for observers.
#pragma once

#include <memory>
#include <vector>

#include "gpu/host/device_memory.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/contract/path_buffers.h"
#include "reference/contract/stage_inputs.h"

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
          variance(budget),
          filtered(budget) {}

    void resize(std::size_t count) {
        reference::for_each_by_ray(
            *this, [&](const auto& of, auto& buffer) { buffer.resize(count, of.name.data()); });
    }
    /// What the stage, which is run alone, reads is taken from its view; the rest has the size of
    /// it, filled with 0xff bytes, so that what the kernel leaves alone shows.
    void load(const reference::StageView& stage, std::size_t count) {
        const reference::StageBuffers in(stage);
        reference::for_each_by_ray(*this, [&](const auto& of, auto& buffer) {
            if (reference::reads(stage.kind, of)) {
                buffer.upload(in.input(of, count), of.name.data());
            } else {
                buffer.resize(count, of.name.data());
                buffer.fill_bytes(0xff);
            }
        });
    }
    void release() {
        reference::for_each_path_buffer(*this, [](const auto&, auto& buffer) { buffer.release(); });
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(rays.size()); }

    DeviceMemory<reference::Ray> rays, shadow_rays;
    DeviceMemory<reference::Vec3> throughput, radiance, potential;
    DeviceMemory<std::uint32_t> pixel, sample, depth, flags;
    DeviceMemory<reference::Hit> path_hits, shadow_hits;
    DeviceMemory<reference::Vec3> image, variance, filtered;
};

/// Copies buffers to the host on demand; the views stay valid as long as this lives.
class HostPathState {
 public:
    explicit HostPathState(const PathState& device) : device_(device) {}

    reference::BufferView view(const reference::BufferInfo& wanted) {
        reference::BufferView result;
        reference::for_each_path_buffer(device_, [&](const auto& of, const auto& buffer) {
            if (of.name == wanted.name) result = copied(of, buffer);
        });
        return result;
    }

 private:
    template <class T>
    reference::BufferView copied(const reference::Buffer<T>& of, const DeviceMemory<T>& buffer) {
        auto host = std::make_shared<std::vector<T>>(
            download(buffer.data(), buffer.size(), of.name.data()));
        kept_.push_back(host);
        return reference::buffer_view(of, std::span<const T>(*host));
    }

    const PathState& device_;
    std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
