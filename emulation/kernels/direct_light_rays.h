/// Kernel: one direct-light sample per path vertex: a shadow ray and the radiance it may add.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/numerics/path.h"

namespace scotty::emulation {

/// The path's own hit stays as it is; the potential radiance waits in the path state.
inline void direct_light_rays(std::uint32_t ray_id, const reference::SceneView& scene,
                              const reference::PathParameters& parameters, std::uint32_t bounce,
                              std::uint32_t light_sample, const PathView& paths,
                              const reference::Hit* path_hits, reference::Ray* shadow_rays) {
    reference::DirectLight light{reference::dead_ray(), reference::Vec3(0.0f, 0.0f, 0.0f)};
    if ((paths.flags[ray_id] & reference::kPathAlive) != 0 &&
        reference::is_hit(path_hits[ray_id])) {
        light = reference::sample_direct_light(
            scene, parameters, paths.rays[ray_id], path_hits[ray_id], paths.throughput[ray_id],
            reference::random4(
                parameters.seed, paths.pixel[ray_id], paths.sample[ray_id], bounce,
                static_cast<std::uint32_t>(reference::Dimension::light) + light_sample));
    }
    shadow_rays[ray_id] = light.shadow;
    paths.potential[ray_id] = light.potential;
}

}  // namespace scotty::emulation
