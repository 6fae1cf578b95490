/// Kernel: what a traversal starts from: no hits, and a minimum of t_max.
#pragma once

#include "gpu/dialect.h"
#include "gpu/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(clear_traversal)
(std::uint32_t count, const reference::Ray* rays, HitView hits, float* minimum, float* lowered) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    if (hits.packed_mode != 0) {
        hits.packed[ray_id] = kNoPackedHit;
    } else {
        hits.counts[ray_id] = 0;
    }
    if (minimum != nullptr) minimum[ray_id] = rays[ray_id].t_max;
    if (lowered != nullptr) lowered[ray_id] = rays[ray_id].t_max;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
