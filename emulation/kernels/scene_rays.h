/// Kernel: adds the emission that a path has met and sends it on by its material's BSDF.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/numerics/path.h"

namespace scotty::emulation {

inline void scene_rays(std::uint32_t ray_id, const reference::SceneView& scene,
                       const reference::PathParameters& parameters, std::uint32_t bounce,
                       const reference::Hit* path_hits, const PathView& paths) {
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

}  // namespace scotty::emulation
