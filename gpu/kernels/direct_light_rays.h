/// Kernel: one direct-light sample per path vertex: a shadow ray and the radiance it may add.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(direct_light_rays)
(std::uint32_t count, reference::SceneView scene, reference::PathParameters parameters,
 std::uint32_t bounce, std::uint32_t light_sample, PathView paths, const reference::Hit* path_hits,
 reference::Ray* shadow_rays) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    const reference::Hit hit = load_record(path_hits + ray_id);
    reference::ask_for_light(scene, parameters, bounce, light_sample, hit, paths, ray_id,
                             shadow_rays[ray_id]);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
