/// State of the paths in flight, in device memory.
#pragma once

#include "gpu/host/device_memory.h"
#include "gpu/host/host_copies.h"
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
    reference::BufferView view(const reference::BufferInfo& wanted, HostCopies& copies) const {
        reference::BufferView shown;
        reference::for_each_path_buffer(*this, [&](const auto& of, const auto& buffer) {
            if (of.name == wanted.name) shown = copies.view(of, buffer.data(), buffer.size());
        });
        return shown;
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(rays.size()); }

    DeviceMemory<reference::Ray> rays, shadow_rays;
    DeviceMemory<reference::Vec3> throughput, radiance, potential;
    DeviceMemory<std::uint32_t> pixel, sample, depth, flags;
    DeviceMemory<reference::Hit> path_hits, shadow_hits;
    DeviceMemory<reference::Vec3> image, variance, filtered;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
