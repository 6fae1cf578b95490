/// Kernels: the last level that has queues, where that is not the last of the tree. Rays go on from
/// their nodes depth first: each alone where any hit will do (the order of visits is part of the
/// result then), through the pool of a warp where the closest is asked for.
#pragma once

#include "gpu/dialect.h"
#include "gpu/intersect.h"
#include "gpu/merge_intersections.h"
#include "gpu/subtree_access.h"
#include "gpu/subtree_pool.h"
#include "gpu/views.h"
#include "reference/closest_in_subtree.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// At level 0 (`level.queue` is null) a ray's id is its place, and its traversal begins here.
SCOTTY_DEVICE std::uint32_t queued_ray(const LevelView& level, std::uint32_t node,
                                       std::uint32_t entry) {
    return level.queue == nullptr ? entry : level.queue[level.queue_offsets[node] + entry];
}

/// A ray of the queue, as its traversal is when it comes here.
struct QueuedRay {
    reference::Ray ray;
    float limit;
};
SCOTTY_DEVICE QueuedRay load_queued(const reference::Ray* rays, std::uint32_t ray_id, bool first,
                                    const HitView& hits, const MinimumView& minimum, bool merges) {
    const reference::Ray ray = load_record(rays + ray_id);
    if (first && !merges) begin_ray(ray_id, ray, hits, minimum);
    return {ray, limit_of(ray_id, ray, first, minimum)};
}

template <int Width>
SCOTTY_KERNEL(intersect_subtrees_any)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 bool strided, FinalHits final_hits) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    const bool merges = final_hits.merged != nullptr;
    const SubtreeAccess<Width> access{bvh};
    const BlockGrid grid = block_grid(level, strided);
    for (std::uint32_t launched = block_index(); launched < grid.launched;
         launched += grid_size()) {
        const std::uint32_t id = logical_block(grid, launched);
        if (id >= grid.total) continue;
        const auto [node, entry] = SCOTTY_AWAIT(find_work(level, id));
        if (entry >= level.node_counts[node]) continue;
        const std::uint32_t ray_id = queued_ray(level, node, entry);
        const auto [ray, limit] =
            load_queued(rays, ray_id, level.queue == nullptr, hits, minimum, merges);
        const reference::HitCandidate best = reference::closest_in_subtree<Width>(
            access, access.root(level.first_node + node), ray, limit, true);
        if (merges) {
            merge_hit(final_hits.scene, best, ray.origin, reference::safe_inverse(ray.direction),
                      reference::ray_shear(ray.direction), final_hits.merged[ray_id]);
        } else if (best.primitive != reference::kNone) {
            record_hit(ray_id, best, hits, minimum);
        }
    }
}

/// Blocks of one warp: each takes 32 rays of what is a block elsewhere.
template <int Width>
SCOTTY_KERNEL(intersect_subtrees_closest)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 std::uint32_t rays_per_block, bool strided, FinalHits final_hits) {
    SCOTTY_SHARED(SubtreePool<Width>, pool);
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    const bool merges = final_hits.merged != nullptr;
    const SubtreeAccess<Width> access{bvh};
    const std::uint32_t parts = rays_per_block / kPoolRays;
    const std::uint32_t place = lane_index();
    const BlockGrid grid = block_grid(level, strided);
    for (std::uint32_t launched = block_index(); launched < grid.launched * parts;
         launched += grid_size()) {
        const std::uint32_t id = logical_block(grid, launched / parts);
        if (id >= grid.total) continue;
        const std::uint32_t node =
            SCOTTY_AWAIT(find_node(level.block_offsets, level.node_count, id));
        const std::uint32_t begin =
            (id - level.block_offsets[node]) * rays_per_block + launched % parts * kPoolRays;
        const std::uint32_t end = level.node_counts[node];
        if (begin >= end) continue;
        const std::uint32_t count = end - begin < kPoolRays ? end - begin : kPoolRays;
        const std::uint32_t root = access.root(level.first_node + node);
        const bool at_leaf = reference::is_leaf(root);
        if (place < count) {
            const std::uint32_t ray_id = queued_ray(level, node, begin + place);
            const auto [ray, limit] =
                load_queued(rays, ray_id, level.queue == nullptr, hits, minimum, merges);
            put_ray(pool, place, ray_id, ray, reference::slabs_of_subtree<Width>(access, root, ray),
                    limit);
            (at_leaf ? pool.leaves : pool.nodes)[place] =
                visit_of(root, float_bits(reference::first_entry(ray)), place);
        }
        SCOTTY_SYNC();
        SCOTTY_AWAIT(
            empty_pool(pool, access, PoolCounts{at_leaf ? 0 : count, at_leaf ? count : 0}));
        if (place < count) {
            const reference::HitCandidate best = unpacked_hit(pool.best[place]);
            if (merges) {
                merge_hit(final_hits.scene, best, pool.origin_of(place), pool.inverse_of(place),
                          pool.shear_of(place), final_hits.merged[pool.ray_id[place]]);
            } else if (best.primitive != reference::kNone) {
                record_hit(pool.ray_id[place], best, hits, minimum);
            }
        }
        SCOTTY_SYNC();
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
