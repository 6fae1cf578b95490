/// Kernel: adds the emission that a path has met and sends it on by its material's BSDF.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/numerics/path.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(scene_rays)
(std::uint32_t count, reference::SceneView scene, reference::PathParameters parameters,
 std::uint32_t bounce, const reference::Hit* path_hits, PathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    const reference::Scattered next = reference::scatter(
        scene, parameters, bounce, paths.rays[ray_id], path_hits[ray_id], paths.throughput[ray_id],
        paths.flags[ray_id],
        reference::random4(parameters.seed, paths.pixel[ray_id], paths.sample[ray_id], bounce,
                           static_cast<std::uint32_t>(reference::Dimension::scatter)));
    paths.radiance[ray_id] += next.emitted;
    paths.rays[ray_id] = next.ray;
    paths.throughput[ray_id] = next.throughput;
    paths.flags[ray_id] = next.flags;
    if ((next.flags & reference::kPathAlive) != 0) ++paths.depth[ray_id];
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
