/// Kernel: one level of the breadth-first traversal. One block takes up to B rays of one node.
///
/// The grid is as large as the device holds at once, and each block takes one logical block after
/// another: only the device knows their number, and the host never waits for it.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kIntersectWarps = 32;
constexpr std::uint32_t kLeafChunk = 64;  ///< triangles in shared memory at once

/// Shared memory of one block: a node and the compaction's counters, or a piece of a leaf.
template <int Width>
struct IntersectShared {
    reference::WideNode<Width> node;
    std::uint32_t warp_counts[Width][kIntersectWarps];
    std::uint32_t base[Width];
    TriangleRows triangles[kLeafChunk];
};

/// A thread's work: a node's queue, and an entry of it.
struct BlockWork {
    std::uint32_t node;
    std::uint32_t entry;
};

/// The smallest side of a square that holds `blocks`.
SCOTTY_DEVICE std::uint32_t side_of_grid(std::uint32_t blocks) {
    auto side = static_cast<std::uint32_t>(sqrtf(static_cast<float>(blocks)));
    while (side > 0 && static_cast<std::uint64_t>(side - 1) * (side - 1) >= blocks) --side;
    while (static_cast<std::uint64_t>(side) * side < blocks) ++side;
    return side;
}

/// Parallel search: the lanes of a warp probe the scanned block offsets together, and each round
/// narrows the range 32 times. Every warp of the block finds the same node.
SCOTTY_COLLECTIVE(std::uint32_t)
find_node(const std::uint32_t* block_offsets, std::uint32_t node_count, std::uint32_t block_id) {
    std::uint32_t low = 0;
    std::uint32_t length = node_count;
    while (length > 1) {
        const std::uint32_t step = (length + kWarpSize - 1) / kWarpSize;
        const std::uint32_t probe = lane_index() * step;
        const bool passed = probe < length && block_offsets[low + probe] <= block_id;
        const std::uint32_t skipped = (count_bits(SCOTTY_AWAIT(warp_ballot(passed))) - 1) * step;
        low += skipped;
        length = step < length - skipped ? step : length - skipped;
    }
    SCOTTY_RETURN low;
}

/// Bit c: the ray enters child c and is not culled.
template <int Width>
SCOTTY_DEVICE std::uint32_t children_entered(const reference::WideNode<Width>& node,
                                             const reference::Ray& ray, float limit) {
    using reference::Vec3;
    const float pad = reference::box_pad(ray.origin, Vec3(node.low[0], node.low[1], node.low[2]),
                                         Vec3(node.high[0], node.high[1], node.high[2]));
    const reference::RaySlabs slabs =
        reference::ray_slabs(ray.origin, reference::safe_inverse(ray.direction), pad);
    std::uint32_t entered = 0;
#pragma unroll
    for (int child = 0; child < Width; ++child) {
        const reference::BoxInterval interval = reference::clip(
            reference::intersect_box(
                slabs, Vec3(node.low_x[child], node.low_y[child], node.low_z[child]),
                Vec3(node.high_x[child], node.high_y[child], node.high_z[child])),
            ray.t_min, ray.t_max);
        const bool enters = reference::overlaps(interval) && interval.entry <= limit &&
                            node.child[child] != reference::kNone;
        entered |= static_cast<std::uint32_t>(enters) << child;
    }
    return entered;
}

/// Ranks by ballot in the warp and a scan over the warps; one atomicAdd per child; scatter.
template <int Width>
SCOTTY_COLLECTIVE(void)
push_to_children(std::uint32_t entered, std::uint32_t ray_id, const LevelView& level,
                 IntersectShared<Width>& shared) {
    const std::uint32_t warps = block_size() / kWarpSize;
    const auto counted = SCOTTY_AWAIT(warp_ballots<Width>(entered));
    if (lane_index() == 0) {
#pragma unroll
        for (int child = 0; child < Width; ++child) {
            shared.warp_counts[child][warp_index()] = count_bits(counted.of[child]);
        }
    }
    SCOTTY_SYNC();
    if (thread_index() < Width) {
        const std::uint32_t child = thread_index();
        std::uint32_t total = 0;
        for (std::uint32_t warp = 0; warp < warps; ++warp) {
            const std::uint32_t own = shared.warp_counts[child][warp];
            shared.warp_counts[child][warp] = total;
            total += own;
        }
        if (total != 0) {
            const std::uint32_t target = shared.node.child[child] - level.first_child_node;
            const std::uint32_t begin = level.child_offsets[target];
            const std::uint32_t room = level.child_offsets[target + 1] - begin;
            const std::uint32_t taken = atomic_add(&level.child_counts[target], total);
            const bool fits = taken + total <= room;
            if (!fits) atomic_max(&level.faults->node_overflow, shared.node.child[child] + 1);
            shared.base[child] = fits ? begin + taken : reference::kNone;
        }
    }
    SCOTTY_SYNC();
    const auto ballots =
        SCOTTY_AWAIT(warp_ballots<Width>(entered));  // again: kept, they would cost Width registers
#pragma unroll
    for (int child = 0; child < Width; ++child) {
        const bool mine = (entered >> child & 1u) != 0;
        if (mine && shared.base[child] != reference::kNone) {
            level.child_queue[shared.base[child] + shared.warp_counts[child][warp_index()] +
                              count_bits(bits_below_lane(ballots.of[child]))] = ray_id;
        }
    }
    SCOTTY_RETURN;
}

SCOTTY_DEVICE void record_hit(std::uint32_t ray_id, const reference::HitCandidate& hit,
                              const HitView& hits, const MinimumView& minimum) {
    if (hits.packed_mode != 0) {
        atomic_min(&hits.packed[ray_id],
                   static_cast<std::uint64_t>(float_bits(hit.t)) << 32 | hit.primitive);
    } else {
        const std::uint32_t slot = atomic_add(&hits.counts[ray_id], 1);
        if (slot < hits.capacity) {
            hits.candidates[static_cast<std::size_t>(ray_id) * hits.capacity + slot] = hit;
        } else {
            atomic_max(&hits.faults->hits_needed, slot + 1);
        }
    }
    if (minimum.culls != 0) {
        atomic_min_distance(&minimum.lowered[ray_id], minimum.any_hit != 0 ? kDone : hit.t);
    }
}

/// The state in which a ray's traversal starts: no hits, and a minimum of t_max.
SCOTTY_DEVICE void begin_ray(std::uint32_t ray_id, const reference::Ray& ray, const HitView& hits,
                             const MinimumView& minimum) {
    if (hits.packed_mode != 0) {
        hits.packed[ray_id] = kNoPackedHit;
    } else {
        hits.counts[ray_id] = 0;
    }
    if (minimum.culls == 0) return;
    minimum.minimum[ray_id] = ray.t_max;
    if (minimum.lowered != minimum.minimum) minimum.lowered[ray_id] = ray.t_max;
}

/// The distance that culls a ray in this launch; at the `first` there is none to read yet.
SCOTTY_DEVICE float limit_of(std::uint32_t ray_id, const reference::Ray& ray, bool first,
                             const MinimumView& minimum) {
    if (minimum.culls == 0) return reference::kInfinity;
    return first ? ray.t_max : load_relaxed(minimum.minimum + ray_id);
}

/// Finds the closest hit of each ray of the block in one leaf, through shared memory.
template <int Width>
SCOTTY_COLLECTIVE(void)
intersect_leaf(const reference::Leaf& leaf, const TriangleRows* triangles, bool active,
               std::uint32_t ray_id, const reference::Ray& ray, float limit, const HitView& hits,
               const MinimumView& minimum, IntersectShared<Width>& shared) {
    constexpr std::uint32_t kWords = sizeof(TriangleRows) / 4;
    const reference::Vec3 inverse = reference::safe_inverse(ray.direction);
    const reference::RayShear shear = reference::ray_shear(ray.direction);
    reference::Hit best = reference::no_hit();
    for (std::uint32_t done = 0; done < leaf.count; done += kLeafChunk) {
        const std::uint32_t chunk = leaf.count - done < kLeafChunk ? leaf.count - done : kLeafChunk;
        const auto* from = reinterpret_cast<const std::uint32_t*>(triangles + leaf.first + done);
        auto* to = reinterpret_cast<std::uint32_t*>(shared.triangles);
        for (std::uint32_t word = thread_index(); word < chunk * kWords; word += block_size()) {
            to[word] = from[word];
        }
        SCOTTY_SYNC();
        for (std::uint32_t i = 0; active && i < chunk; ++i) {
            const auto& [x, y, z] = shared.triangles[i].axis;
            const std::uint32_t primitive = shared.triangles[i].primitive();
            reference::Hit hit = reference::no_hit();
            if (reference::intersect_triangle_line(ray.origin, inverse, shear, {x.v0, y.v0, z.v0},
                                                   {x.v1, y.v1, z.v1}, {x.v2, y.v2, z.v2}, hit) &&
                ray.t_min <= hit.t && hit.t < ray.t_max &&
                reference::closer(hit.t, primitive, best.t, best.primitive)) {
                best = hit;
                best.primitive = primitive;
            }
        }
        SCOTTY_SYNC();
    }
    if (reference::is_hit(best) && best.t <= limit) {
        record_hit(ray_id, {best.t, best.primitive}, hits, minimum);
    }
    SCOTTY_RETURN;
}

template <int Width>
SCOTTY_DEVICE void load_node(const reference::WideNode<Width>& node,
                             IntersectShared<Width>& shared) {
    constexpr std::uint32_t kWords = sizeof(reference::WideNode<Width>) / 4;
    const auto* from = reinterpret_cast<const std::uint32_t*>(&node);
    auto* to = reinterpret_cast<std::uint32_t*>(&shared.node);
    for (std::uint32_t word = thread_index(); word < kWords; word += block_size()) {
        to[word] = from[word];
    }
}

/// The level's blocks as they are launched: in line, or on a square that holds them.
struct BlockGrid {
    std::uint32_t total;
    std::uint32_t side;  ///< 0: in line
    std::uint32_t launched;
};

SCOTTY_DEVICE BlockGrid grid_of(std::uint32_t total, bool strided) {
    const std::uint32_t side = strided ? side_of_grid(total) : 0;
    return {total, side, strided ? side * side : total};
}

SCOTTY_DEVICE BlockGrid block_grid(const LevelView& level, bool strided) {
    return grid_of(level.block_offsets[level.node_count], strided);
}

/// Logical index of a launched block; for idle ones it is at least the total.
SCOTTY_DEVICE std::uint32_t logical_block(const BlockGrid& grid, std::uint32_t launched) {
    return grid.side == 0 ? launched : launched % grid.side * grid.side + launched / grid.side;
}

SCOTTY_COLLECTIVE(BlockWork) find_work(const LevelView& level, std::uint32_t block_id) {
    const std::uint32_t node =
        SCOTTY_AWAIT(find_node(level.block_offsets, level.node_count, block_id));
    SCOTTY_RETURN BlockWork{node,
                            (block_id - level.block_offsets[node]) * block_size() + thread_index()};
}

template <int Width>
SCOTTY_KERNEL(intersect)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 bool strided) {
    SCOTTY_SHARED(IntersectShared<Width>, shared);
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;  // the host grows the queue and retries
    const BlockGrid grid = block_grid(level, strided);
    for (std::uint32_t launched = block_index(); launched < grid.launched;
         launched += grid_size()) {
        const std::uint32_t id = logical_block(grid, launched);
        if (id >= grid.total) continue;
        const auto [node, entry] = SCOTTY_AWAIT(find_work(level, id));
        const bool active = entry < level.node_counts[node];
        const std::uint32_t node_ref = bvh.node_refs[level.first_node + node];

        std::uint32_t ray_id = 0;
        reference::Ray ray = reference::dead_ray();
        float limit = reference::kInfinity;
        if (active) {
            ray_id = level.queue[level.queue_offsets[node] + entry];
            ray = load_record(rays + ray_id);
            limit = limit_of(ray_id, ray, false, minimum);
        }
        if (reference::is_leaf(node_ref)) {
            SCOTTY_AWAIT(intersect_leaf(bvh.leaves[reference::ref_index(node_ref)], bvh.triangles,
                                        active, ray_id, ray, limit, hits, minimum, shared));
        } else {
            load_node(bvh.inner[reference::ref_index(node_ref)], shared);
            SCOTTY_SYNC();
            const std::uint32_t entered = active ? children_entered(shared.node, ray, limit) : 0;
            SCOTTY_AWAIT(push_to_children(entered, ray_id, level, shared));
        }
        SCOTTY_SYNC();
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
