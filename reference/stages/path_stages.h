/// The shading stages for one ray: random numbers, reference/numerics/path.h, and the path's state.
#pragma once

#include <cstdint>

#include "reference/base/host_device.h"
#include "reference/contract/views.h"
#include "reference/numerics/path.h"

namespace scotty::reference {

/// Stage primary_rays: `ray_id` becomes the fresh path of a pixel's sample.
SCOTTY_STAGE void start_path(const Camera& camera, const PathParameters& parameters,
                             std::uint32_t pixel, std::uint32_t sample, const PathView& paths,
                             std::uint32_t ray_id) {
    paths.rays[ray_id] = primary_ray(camera, parameters, pixel, sample);
    paths.throughput[ray_id] = Vec3(1.0f, 1.0f, 1.0f);
    paths.radiance[ray_id] = Vec3(0.0f, 0.0f, 0.0f);
    paths.potential[ray_id] = Vec3(0.0f, 0.0f, 0.0f);
    paths.pixel[ray_id] = pixel;
    paths.sample[ray_id] = sample;
    paths.depth[ray_id] = 0;
    paths.flags[ray_id] = kPathAlive;
}

/// Stage direct_light_rays: one light sample at the path's vertex. Writes the shadow ray, dead
/// where there is nothing to ask; the potential radiance waits in the path's state.
SCOTTY_STAGE void ask_for_light(const SceneView& scene, const PathParameters& parameters,
                                std::uint32_t bounce, std::uint32_t light_sample, const Hit& hit,
                                const PathView& paths, std::uint32_t ray_id, Ray& shadow_ray) {
    DirectLight light{dead_ray(), Vec3(0.0f, 0.0f, 0.0f)};
    if ((paths.flags[ray_id] & kPathAlive) != 0 && is_hit(hit)) {
        light = sample_direct_light(
            scene, parameters, paths.rays[ray_id], hit, paths.throughput[ray_id],
            random4(parameters.seed, paths.pixel[ray_id], paths.sample[ray_id], bounce,
                    static_cast<std::uint32_t>(Dimension::light) + light_sample));
    }
    shadow_ray = light.shadow;
    paths.potential[ray_id] = light.potential;
}

/// Stage scene_rays: adds the emission that the path has met and sends it on by its material's
/// BSDF.
SCOTTY_STAGE void advance_path(const SceneView& scene, const PathParameters& parameters,
                               std::uint32_t bounce, const Hit& hit, const PathView& paths,
                               std::uint32_t ray_id) {
    const Scattered next =
        scatter(scene, parameters, bounce, paths.rays[ray_id], hit, paths.throughput[ray_id],
                paths.flags[ray_id],
                random4(parameters.seed, paths.pixel[ray_id], paths.sample[ray_id], bounce,
                        static_cast<std::uint32_t>(Dimension::scatter)));
    paths.radiance[ray_id] += next.emitted;
    paths.rays[ray_id] = next.ray;
    paths.throughput[ray_id] = next.throughput;
    paths.flags[ray_id] = next.flags;
    if ((next.flags & kPathAlive) != 0) ++paths.depth[ray_id];
}

}  // namespace scotty::reference
