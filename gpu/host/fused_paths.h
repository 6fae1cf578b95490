/// The paths of a render whose shading nobody follows, in device memory;
/// gpu/kernels/fused_shading.h has the kernels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gpu/host/cuda_error.h"
#include "gpu/host/device_memory.h"
#include "gpu/host/launch_log.h"
#include "gpu/host/path_state.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/fused_shading.h"

namespace SCOTTY_DEVICE_NAMESPACE {

struct FusedPaths {
    explicit FusedPaths(MemoryBudget& budget)
        : shadow_rays(budget), potential(budget), emission(budget), triangles(budget) {}

    static bool can_have(std::uint32_t light_samples) {
        return light_samples >= 1 && light_samples <= kMostFusedLights;
    }
    /// Of `paths` only what is used gets room.
    void resize(PathState& paths, std::size_t count, std::uint32_t lights) {
        namespace buffers = reference::buffers;
        paths.rays.resize(count, buffers::rays.name.data());
        paths.throughput.resize(count, buffers::throughput.name.data());
        paths.radiance.resize(count, buffers::radiance.name.data());
        paths.flags.resize(count, buffers::flags.name.data());
        paths.path_hits.resize(count, buffers::path_hits.name.data());
        shadow_rays.resize(count * lights, "shadow rays of all light samples");
        potential.resize(count * lights, "potential of all light samples");
        emission.resize(count, "emission that waits");
    }
    void release() {
        shadow_rays.release();
        potential.release();
        emission.release();
        triangles.release();
    }
    /// Once for a scene, which stays what it is.
    void pack(const reference::SceneView& scene, cudaStream_t stream) {
        if (triangles.data() != nullptr) return;
        triangles.resize(scene.triangle_count, "triangles to be shaded");
        SCOTTY_LAUNCH(pack_triangles, item_blocks(scene.triangle_count), kItemThreads, stream,
                      scene, triangles.data());
        check(cudaGetLastError(), "packing triangles");
    }
    FusedPathView view(const PathState& paths) const {
        return {paths.count(),         paths.rays.data(),  paths.throughput.data(),
                paths.radiance.data(), paths.flags.data(), paths.path_hits.data(),
                shadow_rays.data(),    potential.data(),   emission.data(),
                triangles.data()};
    }

    DeviceMemory<reference::Ray> shadow_rays;
    DeviceMemory<reference::Vec3> potential, emission;
    DeviceMemory<ShadedTriangle> triangles;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
