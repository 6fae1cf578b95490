/// State of the paths in flight and of the image, in the virtual device's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "emulation/device/device_buffer.h"
#include "emulation/kernels/views.h"
#include "reference/contract/path_buffers.h"
#include "reference/contract/stage_inputs.h"

namespace scotty::emulation {

struct PathState {
    explicit PathState(Device& device)
        : rays(device, "rays"),
          shadow_rays(device, "shadow rays"),
          throughput(device, "throughput"),
          radiance(device, "radiance"),
          potential(device, "potential radiance"),
          pixel(device, "pixels"),
          sample(device, "samples"),
          depth(device, "depths"),
          flags(device, "flags"),
          path_hits(device, "path hits"),
          shadow_hits(device, "shadow hits"),
          image(device, "the image"),
          variance(device, "the image's variance"),
          filtered(device, "the filtered image") {}

    void resize(std::size_t count) {
        reference::for_each_by_ray(*this, [&](const auto&, auto& buffer) { buffer.resize(count); });
    }
    /// What the stage, which is run alone, reads is taken from its view; the rest has the size of
    /// it.
    void load(const reference::StageView& stage, std::size_t count) {
        const reference::StageBuffers in(stage);
        reference::for_each_by_ray(*this, [&](const auto& of, auto& buffer) {
            buffer.resize(count);
            if (reference::reads(stage.kind, of)) buffer.assign(in.input(of, count));
        });
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(rays.size()); }
    reference::BufferView view(const reference::BufferInfo& wanted) const {
        reference::BufferView result;
        reference::for_each_path_buffer(*this, [&](const auto& of, const auto& buffer) {
            if (of.name == wanted.name) result = reference::buffer_view(of, buffer.view());
        });
        return result;
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        reference::for_each_path_buffer(
            *this, [&](const auto&, const auto& buffer) { sum += buffer.bytes(); });
        return sum;
    }

    DeviceBuffer<reference::Ray> rays, shadow_rays;
    DeviceBuffer<reference::Vec3> throughput, radiance, potential;
    DeviceBuffer<std::uint32_t> pixel, sample, depth, flags;
    DeviceBuffer<reference::Hit> path_hits, shadow_hits;
    DeviceBuffer<reference::Vec3> image, variance, filtered;
};

}  // namespace scotty::emulation
