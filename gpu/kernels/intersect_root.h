/// Kernel: level 0, where traversals begin. It has one node, whose queue need not exist: ray ids
/// are thread ids.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// The root is always an inner node (reference/contract/wide_bvh.h): no search and no leaf.
template <int Width>
SCOTTY_KERNEL(intersect_root)
(BvhView<Width> bvh, const reference::Ray* rays, std::uint32_t ray_count, LevelView level,
 HitView hits, MinimumView minimum) {
    SCOTTY_SHARED(IntersectShared<Width>, shared);
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    load_node(bvh.inner[0], shared);
    SCOTTY_SYNC();
    const std::uint32_t blocks = (ray_count + block_size() - 1) / block_size();
    for (std::uint32_t id = block_index(); id < blocks; id += grid_size()) {
        const std::uint32_t ray_id = id * block_size() + thread_index();
        std::uint32_t entered = 0;
        if (ray_id < ray_count) {
            const reference::Ray ray = load_record(rays + ray_id);
            begin_ray(ray_id, ray, hits, minimum);
            entered = children_entered(shared.node, ray, limit_of(ray_id, ray, true, minimum));
        }
        SCOTTY_AWAIT(push_to_children(entered, ray_id, level, shared));
        SCOTTY_SYNC();
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
