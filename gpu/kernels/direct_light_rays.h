/// Kernel: one direct-light sample per path vertex: a shadow ray and the radiance it may add.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/numerics/path.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(direct_light_rays)
(std::uint32_t count, reference::SceneView scene, reference::PathParameters parameters,
 std::uint32_t bounce, std::uint32_t light_sample, PathView paths, const reference::Hit* path_hits,
 reference::Ray* shadow_rays) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    reference::DirectLight light{reference::dead_ray(), reference::Vec3(0.0f, 0.0f, 0.0f)};
    const reference::Hit hit = load_record(path_hits + ray_id);
    if ((paths.flags[ray_id] & reference::kPathAlive) != 0 && reference::is_hit(hit)) {
        light = reference::sample_direct_light(
            scene, parameters, paths.rays[ray_id], hit, paths.throughput[ray_id],
            reference::random4(
                parameters.seed, paths.pixel[ray_id], paths.sample[ray_id], bounce,
                static_cast<std::uint32_t>(reference::Dimension::light) + light_sample));
    }
    shadow_rays[ray_id] = light.shadow;
    paths.potential[ray_id] = light.potential;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
