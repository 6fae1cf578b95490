/// Kernel: the last level that has queues, if the tree goes on below it. Rays go on from their
/// nodes depth-first, each alone.
///
/// Rays of one warp end at different times. Where they are incoherent, warps stay, and idle lanes
/// take new rays as soon as there are a few (Aila and Laine, "Understanding the Efficiency of Ray
/// Traversal on GPUs", HPG 2009). Coherent rays stay side by side: at level 0 a thread has one ray,
/// and from a queue a warp takes the next 32 when its rays are done.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/subtree_ray.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kSubtreeThreads = 128;
constexpr std::uint32_t kSubtreeBlocks = 7;  ///< at once on a multiprocessor: 72 registers each
constexpr std::uint32_t kIdleLanes = 8;      ///< of incoherent rays, before they take new ones

/// If a traversal ends with its first launch, a ray's hit is final then: no buffer and no merge
/// follow, nor, for shadow rays, resolve_light.
struct FinalHits {
    reference::Hit* merged = nullptr;            ///< null: not used
    const reference::Vec3* potential = nullptr;  ///< added to the radiance of rays without a hit
    reference::Vec3* radiance = nullptr;         ///< null: not used
};

template <int Width>
SCOTTY_DEVICE void end_ray(const SubtreeRay<Width>& walk, std::uint32_t ray_id, const HitView& hits,
                           const MinimumView& minimum, const FinalHits& final_hits) {
    const bool hit = has_hit(walk);
    if (final_hits.merged != nullptr) {
        store_record(final_hits.merged + ray_id, best_hit(walk));
    } else if (final_hits.radiance != nullptr) {
        const bool alive = walk.t_min <= walk.best_t;  // nothing else limits it
        if (alive && !hit) final_hits.radiance[ray_id] += final_hits.potential[ray_id];
    } else if (hit) {
        record_hit(ray_id, {walk.best_t, walk.best_primitive}, hits, minimum);
    }
}

/// The arguments of a launch besides the level.
struct SubtreeWork {
    std::uint32_t ray_count;
    std::uint32_t rays_per_block;  ///< of a logical block: part of a queue
    bool strided;
    bool coherent;     ///< level 0: one ray per thread
    SubtreeRoot root;  ///< level 0: the BVH's
};

/// Takes the next `count` of the rays that the launch's warps share.
SCOTTY_COLLECTIVE(std::uint32_t) take(std::uint32_t* ticket, std::uint32_t count) {
    std::uint32_t begin = 0;
    if (lane_index() == 0) begin = atomic_add(ticket, count);
    SCOTTY_RETURN SCOTTY_AWAIT(warp_shuffle(begin, 0));
}

/// A warp's next rays. At level 0, where a ray's id is its place, it takes one per thread, or one
/// per idle lane; from queues, 32 entries of a logical block.
struct TakenRays {
    std::uint32_t node;
    std::uint32_t entry;  ///< the lane's; at least the queue's length if it has none
    bool more;            ///< the launch may have more
};
SCOTTY_COLLECTIVE(TakenRays)
take_rays(const LevelView& level, const BlockGrid& grid, const SubtreeWork& work,
          std::uint32_t idle) {
    constexpr std::uint32_t kNoEntry = 0xffffffffu;
    if (level.queue == nullptr && work.coherent) {
        SCOTTY_RETURN TakenRays{0, block_index() * block_size() + thread_index(), false};
    }
    if (level.queue == nullptr) {
        const std::uint32_t begin = SCOTTY_AWAIT(take(&level.ray_ticket->taken, count_bits(idle)));
        const bool is_idle = (idle >> lane_index() & 1u) != 0;
        SCOTTY_RETURN TakenRays{0, is_idle ? begin + count_bits(bits_below_lane(idle)) : kNoEntry,
                                begin + count_bits(idle) < work.ray_count};
    }
    const std::uint32_t parts = work.rays_per_block / kWarpSize;
    const std::uint32_t part = SCOTTY_AWAIT(take(&level.ray_ticket->taken, 1));
    const bool more = part / parts < grid.launched;
    const std::uint32_t id = more ? logical_block(grid, part / parts) : grid.total;
    if (id >= grid.total) SCOTTY_RETURN TakenRays{0, kNoEntry, more};
    const std::uint32_t node = SCOTTY_AWAIT(find_node(level.block_offsets, level.node_count, id));
    SCOTTY_RETURN TakenRays{node,
                            (id - level.block_offsets[node]) * work.rays_per_block +
                                part % parts * kWarpSize + lane_index(),
                            more};
}

/// The last warp of a launch resets the ticket for the next one, which then needs no clearing.
SCOTTY_DEVICE void end_warp(RayTicket* ticket) {
    if (lane_index() != 0) return;
    const std::uint32_t warps = grid_size() * (block_size() / kWarpSize);
    if (atomic_add(&ticket->warps_ended, 1) + 1 != warps) return;
    const std::uint32_t taken = atomic_add(&ticket->taken, 0);
    atomic_add(&ticket->taken, 0u - taken);
    atomic_add(&ticket->warps_ended, 0u - warps);
}

/// Runs until there are no more rays. `Pairs`: they are those of a level's pairs, as many as there
/// are.
template <bool Any, bool Pairs = false, int Width>
SCOTTY_COLLECTIVE(void)
trace_subtrees(const BvhView<Width>& bvh, const reference::Ray* rays, const LevelView& level,
               const HitView& hits, const MinimumView& minimum, const SubtreeWork& work,
               const FinalHits& final_hits) {
    const bool first = !Pairs && level.queue == nullptr;
    const bool is_final = final_hits.merged != nullptr || final_hits.radiance != nullptr;
    const BlockGrid grid = first || Pairs ? BlockGrid{} : block_grid(level, work.strided);
    const std::uint32_t enough_idle = first || Pairs ? kIdleLanes : kWarpSize;
    SubtreeStack stack;
    SubtreeRay<Width> walk;
    walk.at = reference::kNone;
    std::uint32_t ray_id = reference::kNone;
    bool more = true;
    for (;;) {
        const std::uint32_t idle = SCOTTY_AWAIT(warp_ballot(walk.at == reference::kNone));
        if (more && count_bits(idle) >= enough_idle) {
            if (walk.at == reference::kNone && ray_id != reference::kNone) {
                end_ray(walk, ray_id, hits, minimum, final_hits);
                ray_id = reference::kNone;
            }
            const TakenRays taken = SCOTTY_AWAIT(take_rays(level, grid, work, idle));
            more = taken.more;
            if (taken.entry < (first || Pairs ? work.ray_count : level.node_counts[taken.node])) {
                reference::NodeRay pair{0, taken.entry};
                if (Pairs) {
                    pair = load_record(level.pairs + taken.entry);
                } else if (!first) {
                    pair = {bvh.node_refs[level.first_node + taken.node],
                            level.queue[level.queue_offsets[taken.node] + taken.entry]};
                }
                ray_id = pair.ray;
                const reference::Ray ray = load_record(rays + ray_id);
                if (first && !is_final) begin_ray(ray_id, ray, hits, minimum);
                const SubtreeRoot root = first ? work.root : subtree_root(bvh, pair.node);
                begin_subtree(walk, bvh, root, ray, limit_of(ray_id, ray, first, minimum));
            }
        } else if (idle == kWholeWarp) {
            if (ray_id != reference::kNone) end_ray(walk, ray_id, hits, minimum, final_hits);
            if (!work.coherent) end_warp(level.ray_ticket);
            SCOTTY_RETURN;
        } else if (walk.at != reference::kNone) {
            enter_nodes(walk, stack, bvh);
            intersect_leaves<Any>(walk, stack, bvh);
        }
    }
}

template <int Width>
SCOTTY_KERNEL_SIZED(kSubtreeThreads, kSubtreeBlocks, intersect_subtrees_any)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 SubtreeWork work, FinalHits final_hits) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    SCOTTY_AWAIT(trace_subtrees<true>(bvh, rays, level, hits, minimum, work, final_hits));
}

template <int Width>
SCOTTY_KERNEL_SIZED(kSubtreeThreads, kSubtreeBlocks, intersect_subtrees_closest)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 SubtreeWork work, FinalHits final_hits) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    SCOTTY_AWAIT(trace_subtrees<false>(bvh, rays, level, hits, minimum, work, final_hits));
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
