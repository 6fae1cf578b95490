/// Kernels: one level whose rays wait in one queue of (inner node, ray) pairs.
///
/// The grid is as large as the device holds at once, and each block takes one run of B pairs after
/// another, whatever their nodes are. A thread tests the children of its own pair's node, with
/// boxes padded as the root's is. Inner children that are entered are appended to the next level's
/// queue with one atomicAdd a block; leaves are listed in shared memory and tested by all threads
/// of the block, so that few lanes idle and no ray waits for a launch to test a leaf.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/intersect_subtrees.h"
#include "gpu/kernels/subtree_ray.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// A ray in a leaf, as SubtreeNode::child names it.
struct LeafTask {
    std::uint32_t ray;
    std::uint32_t leaf;
};

constexpr std::uint32_t kListedLeaves = 512;  ///< at once; more take several rounds

struct PairShared {
    /// Pairs to append | leaves << 16 of the block's run; the next run counts in the other one.
    std::uint32_t counts[2];
    std::uint32_t base;  ///< of the pairs in the next level's queue; kNone: there is no room
    LeafTask tasks[kListedLeaves];
};

/// The children that a ray enters from its node. Bit c is child c.
struct EnteredChildren {
    std::uint32_t inner;
    std::uint32_t leaves;
};

/// SubtreeNode::child, as it is loaded.
template <int Count>
struct alignas(Count == 2 ? 8 : 16) ChildRefs {
    std::uint32_t at[Count];
};

template <int Width>
SCOTTY_DEVICE EnteredChildren pair_children(const BvhView<Width>& bvh, const SubtreeRoot& root,
                                            std::uint32_t node, const reference::Ray& ray,
                                            float limit) {
    SubtreeRay<Width> walk;
    begin_subtree(walk, bvh, root, ray, limit);
    if (walk.at == reference::kNone) return {};  // the ray is dead
    walk.at = node;
    std::uint32_t keys[Width];
    children_of(walk, keys);
    constexpr int kGroup = SubtreeRay<Width>::kGroup;
    const auto* refs = reinterpret_cast<const ChildRefs<kGroup>*>(bvh.subtrees[node].child);
    EnteredChildren entered{};
    SCOTTY_UNROLL
    for (int group = 0; group < Width / kGroup; ++group) {
        const ChildRefs<kGroup> loaded = load_record(refs + group);
        SCOTTY_UNROLL
        for (int i = 0; i < kGroup; ++i) {
            const int child = group * kGroup + i;
            const bool enters = keys[child] != reference::kNone;
            const bool leaf = reference::is_leaf(loaded.at[i]);
            entered.inner |= static_cast<std::uint32_t>(enters && !leaf) << child;
            entered.leaves |= static_cast<std::uint32_t>(enters && leaf) << child;
        }
    }
    return entered;
}

/// The ray's closest hit in one leaf.
template <int Width>
SCOTTY_DEVICE void test_leaf(const BvhView<Width>& bvh, const reference::Ray* rays,
                             const LeafTask& task, const HitView& hits,
                             const MinimumView& minimum) {
    const reference::Ray ray = load_record(rays + task.ray);
    SubtreeRay<Width> walk;
    begin_subtree(walk, bvh, SubtreeRoot{task.leaf, {}, {}}, ray,
                  limit_of(task.ray, ray, false, minimum));
    std::uint32_t first = 3 * reference::ref_index(task.leaf);
    while (!visit_triangle(walk, bvh.triangles->axis, first)) first += 3;
    if (has_hit(walk)) {
        record_hit(task.ray, {walk.best_t, walk.best_primitive}, hits, minimum);
    }
}

/// Lists those of a warp's leaves for which there is room in this round. Child by child, as pairs
/// are appended too: neighbours are then in the same node or leaf, where their rays were.
template <int Width>
SCOTTY_COLLECTIVE(void)
list_leaves(const BvhView<Width>& bvh, const reference::NodeRay& pair, std::uint32_t leaves,
            std::uint32_t rank, std::uint32_t begin, PairShared& shared) {
    const auto ballots = SCOTTY_AWAIT(warp_ballots<Width>(leaves));
    SCOTTY_UNROLL
    for (int child = 0; child < Width; ++child) {
        const std::uint32_t at = rank + count_bits(bits_below_lane(ballots.of[child])) - begin;
        if ((leaves >> child & 1u) != 0 && at < kListedLeaves) {
            shared.tasks[at] = {pair.ray, load_record(&bvh.subtrees[pair.node].child[child])};
        }
        rank += count_bits(ballots.of[child]);
    }
    SCOTTY_RETURN;
}

/// All threads of the block test what is listed.
template <int Width>
SCOTTY_DEVICE void test_leaves(const BvhView<Width>& bvh, const reference::Ray* rays,
                               std::uint32_t left, const HitView& hits, const MinimumView& minimum,
                               const PairShared& shared) {
    const std::uint32_t listed = left < kListedLeaves ? left : kListedLeaves;
    for (std::uint32_t i = thread_index(); i < listed; i += block_size()) {
        test_leaf(bvh, rays, shared.tasks[i], hits, minimum);
    }
}

/// Room for a block's pairs in the next level's queue. Where there is none, the host makes more and
/// runs the traversal again; the block then asks for no more, so that the counter does not reach
/// its end.
SCOTTY_DEVICE std::uint32_t reserve_pairs(const PairView& level, std::uint32_t appended,
                                          bool& full) {
    if (appended == 0 || full) return reference::kNone;
    const std::uint32_t taken = atomic_add(level.child_count, appended);
    const std::uint64_t needed = static_cast<std::uint64_t>(taken) + appended;
    full = needed > level.capacity;
    if (!full) return taken;
    atomic_max(&level.faults->queue_needed,
               needed < 0xffffffffu ? static_cast<std::uint32_t>(needed) : 0xffffffffu);
    return reference::kNone;
}

template <int Width>
SCOTTY_COLLECTIVE(void)
append_pairs(const BvhView<Width>& bvh, const reference::NodeRay& pair, std::uint32_t inner,
             std::uint32_t rank, const PairView& level, std::uint32_t base) {
    const auto ballots = SCOTTY_AWAIT(warp_ballots<Width>(inner));
    SCOTTY_UNROLL
    for (int child = 0; child < Width; ++child) {
        if ((inner >> child & 1u) != 0 && base != reference::kNone) {
            level.child_pairs[base + rank + count_bits(bits_below_lane(ballots.of[child]))] = {
                load_record(&bvh.subtrees[pair.node].child[child]), pair.ray};
        }
        rank += count_bits(ballots.of[child]);
    }
    SCOTTY_RETURN;
}

/// A warp's place among what the block counts in its run.
SCOTTY_COLLECTIVE(std::uint32_t) count_run(const EnteredChildren& entered, std::uint32_t* counter) {
    // Both counts in one word: a block has at most 1024 * 16 of each.
    std::uint32_t sum = count_bits(entered.inner) | count_bits(entered.leaves) << 16;
    for (std::uint32_t apart = kWarpSize / 2; apart != 0; apart /= 2) {
        sum += SCOTTY_AWAIT(warp_shuffle(sum, lane_index() ^ apart));
    }
    std::uint32_t before = 0;
    if (lane_index() == 0) before = atomic_add(counter, sum);
    SCOTTY_RETURN SCOTTY_AWAIT(warp_shuffle(before, 0));
}

template <int Width>
SCOTTY_KERNEL_SIZED(1024, 1, intersect_pairs)
(BvhView<Width> bvh, const reference::Ray* rays, PairView level, SubtreeRoot root, HitView hits,
 MinimumView minimum, bool strided) {
    SCOTTY_SHARED(PairShared, shared);
    const bool first = level.pairs == nullptr;
    const std::uint32_t count = *level.count;
    if (!first && count > level.capacity) SCOTTY_RETURN;  // the host runs the traversal again
    if (thread_index() < 2) shared.counts[thread_index()] = 0;
    SCOTTY_SYNC();
    const BlockGrid grid = grid_of((count + block_size() - 1) / block_size(), strided);
    std::uint32_t run = 0;
    bool full = false;
    for (std::uint32_t launched = block_index(); launched < grid.launched;
         launched += grid_size()) {
        const std::uint32_t id = logical_block(grid, launched);
        if (id >= grid.total) continue;
        const std::uint32_t entry = id * block_size() + thread_index();
        reference::NodeRay pair{0, entry};
        EnteredChildren entered{};
        if (entry < count) {
            if (!first) pair = load_record(level.pairs + entry);
            const reference::Ray ray = load_record(rays + pair.ray);
            if (first) begin_ray(pair.ray, ray, hits, minimum);
            entered =
                pair_children(bvh, root, pair.node, ray, limit_of(pair.ray, ray, first, minimum));
        }
        const std::uint32_t rank = SCOTTY_AWAIT(count_run(entered, &shared.counts[run]));
        SCOTTY_AWAIT(list_leaves(bvh, pair, entered.leaves, rank >> 16, 0, shared));
        SCOTTY_SYNC();
        const std::uint32_t all = shared.counts[run];
        run ^= 1u;
        if (thread_index() == 0) {
            shared.counts[run] = 0;
            shared.base = reserve_pairs(level, all & 0xffffu, full);
        }
        test_leaves(bvh, rays, all >> 16, hits, minimum, shared);
        for (std::uint32_t begin = kListedLeaves; begin < all >> 16; begin += kListedLeaves) {
            SCOTTY_SYNC();
            SCOTTY_AWAIT(list_leaves(bvh, pair, entered.leaves, rank >> 16, begin, shared));
            SCOTTY_SYNC();
            test_leaves(bvh, rays, (all >> 16) - begin, hits, minimum, shared);
        }
        SCOTTY_SYNC();
        SCOTTY_AWAIT(append_pairs(bvh, pair, entered.inner, rank & 0xffffu, level, shared.base));
    }
}

/// The last level that has a queue, if the tree goes on below it: rays go on from their nodes depth
/// first, each alone, and idle lanes take new pairs.
template <int Width>
SCOTTY_KERNEL_SIZED(kSubtreeThreads, kSubtreeBlocks, intersect_pair_subtrees_any)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 SubtreeWork work, FinalHits final_hits) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    work.ray_count = *level.pair_count;
    SCOTTY_AWAIT((trace_subtrees<true, true>(bvh, rays, level, hits, minimum, work, final_hits)));
}

template <int Width>
SCOTTY_KERNEL_SIZED(kSubtreeThreads, kSubtreeBlocks, intersect_pair_subtrees_closest)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 SubtreeWork work, FinalHits final_hits) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    work.ray_count = *level.pair_count;
    SCOTTY_AWAIT((trace_subtrees<false, true>(bvh, rays, level, hits, minimum, work, final_hits)));
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
