/// Kernel: potential radiance becomes radiance if nothing blocks the way from surface to light.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(resolve_light)
(std::uint32_t count, const reference::Ray* shadow_rays, const reference::Hit* shadow_hits,
 PathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    if (!reference::is_dead(shadow_rays[ray_id]) && !reference::is_hit(shadow_hits[ray_id])) {
        paths.radiance[ray_id] += paths.potential[ray_id];
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
