/// Kernels: one level whose rays wait in one queue of (inner node, ray) pairs. A block takes the
/// next B of them, whatever their nodes are.
///
/// Every ray against the boxes of its own node's children: inner children that it enters become
/// pairs of the next level, by a scan over the block and one atomicAdd on the level's counter;
/// leaves are listed in shared memory, and the block's threads test them in this launch. Boxes are
/// padded as the root's is, at every level, so that a pair is all that a thread has to load besides
/// its ray and the planes. At the root entry p is ray p, and there are no pairs to load.
#pragma once

#include "emulation/kernels/intersect.h"
#include "reference/numerics/closest_in_subtree.h"

namespace scotty::emulation {

/// The queue of one level and of the next.
struct PairView {
    std::uint32_t count;              ///< entries of this level
    const reference::NodeRay* pairs;  ///< null at the root
    std::uint32_t* child_count;       ///< entries of the next level
    reference::NodeRay* child_pairs;  ///< room for as many as the children of all entries
};

/// The pairs that a block has loaded, with one register each per thread.
struct BlockPairs {
    std::uint32_t count;  ///< of the block; 0: an idle block of the 2-D grid
    PerThread<std::uint32_t> node, ray;
    PerThread<float> limit;  ///< nearest hit known; +infinity if nothing culls
};

inline float known_limit(std::uint32_t ray, const MinimumView& minimum) {
    if (minimum.policy == reference::EarlyOut::off) return reference::kInfinity;
    return load_relaxed(minimum.minimum[ray]);
}

inline void load_pairs(const Block& block, const PairView& level, const MinimumView& minimum,
                       std::uint32_t grid_side, BlockPairs& out) {
    const std::uint64_t first =
        std::uint64_t{logical_block(block.index(), grid_side)} * block.threads();
    out.count = first < level.count ? static_cast<std::uint32_t>(std::min<std::uint64_t>(
                                          block.threads(), level.count - first))
                                    : 0;
    block.phase(out.count, [&](std::uint32_t thread) {
        const auto entry = static_cast<std::uint32_t>(first) + thread;
        const reference::NodeRay pair =
            level.pairs == nullptr ? reference::NodeRay{0, entry} : level.pairs[entry];
        out.node[thread] = pair.node;
        out.ray[thread] = pair.ray;
        out.limit[thread] = known_limit(pair.ray, minimum);
    });
}

/// The children that the thread's ray enters. Bit c is child c.
struct BlockEntered {
    PerThread<std::uint32_t> inner, leaves;
};

template <int Width>
void test_pairs(const Block& block, const reference::WideBvhView<Width>& bvh,
                const reference::Ray* rays, const BlockPairs& loaded, BlockEntered& out) {
    block.phase(loaded.count, [&](std::uint32_t thread) {
        const reference::Ray& ray = rays[loaded.ray[thread]];
        const reference::WideNode<Width>& node = bvh.inner[loaded.node[thread]];
        std::uint32_t keys[Width];
        reference::visits_of(node, reference::slabs_below(bvh.inner[0].low, bvh.inner[0].high, ray),
                             reference::first_entry(ray),
                             reference::min_number(ray.t_max, loaded.limit[thread]), keys);
        out.inner[thread] = 0;
        out.leaves[thread] = 0;
        for (std::uint32_t child = 0; child < Width; ++child) {
            if (keys[child] == reference::kNone) continue;
            const bool leaf = reference::is_leaf(bvh.node_refs[node.child[child]]);
            (leaf ? out.leaves : out.inner)[thread] |= 1u << child;
        }
    });
}

/// Ranks by exclusive scan in the block, and one atomicAdd for all that it appends.
template <int Width>
void append_pairs(const Block& block, const reference::WideBvhView<Width>& bvh,
                  const BlockPairs& loaded, const BlockEntered& entered, const PairView& level) {
    PerThread<std::uint32_t> rank;
    std::uint32_t total = 0;
    block.phase_in_order(loaded.count, [&](std::uint32_t thread) {
        rank[thread] = total;
        total += static_cast<std::uint32_t>(std::popcount(entered.inner[thread]));
    });
    if (total == 0) return;
    std::uint32_t base = 0;
    block.phase_thread_zero([&] { base = atomic_add(*level.child_count, total); });
    block.phase(loaded.count, [&](std::uint32_t thread) {
        const reference::WideNode<Width>& node = bvh.inner[loaded.node[thread]];
        reference::NodeRay* slot = level.child_pairs + base + rank[thread];
        for (std::uint32_t child = 0; child < Width; ++child) {
            if ((entered.inner[thread] >> child & 1u) == 0) continue;
            *slot++ = {bvh.node_refs[node.child[child]], loaded.ray[thread]};
        }
    });
}

/// Child by child, the leaves that the block's rays enter are listed, and its threads test them.
template <int Width>
void test_leaves(const Block& block, const reference::WideBvhView<Width>& bvh,
                 const reference::Ray* rays, const BlockPairs& loaded, const BlockEntered& entered,
                 const HitView& hits, const MinimumView& minimum) {
    for (std::uint32_t child = 0; child < Width; ++child) {
        Shared<std::uint32_t> listed_leaf("listed leaves");
        Shared<std::uint32_t> listed_ray("listed rays");
        std::uint32_t listed = 0;
        block.phase_in_order(loaded.count, [&](std::uint32_t thread) {
            if ((entered.leaves[thread] >> child & 1u) == 0) return;
            const std::uint32_t id = bvh.inner[loaded.node[thread]].child[child];
            listed_leaf[listed] = reference::ref_index(bvh.node_refs[id]);
            listed_ray[listed] = loaded.ray[thread];
            ++listed;
        });
        block.phase(listed, [&](std::uint32_t thread) {
            const std::uint32_t ray_id = listed_ray[thread];
            const reference::Ray& ray = rays[ray_id];
            reference::HitCandidate best{reference::kInfinity, reference::kNone};
            reference::closest_in_leaf(bvh.triangles, bvh.leaves[listed_leaf[thread]], ray,
                                       reference::safe_inverse(ray.direction),
                                       reference::ray_shear(ray.direction),
                                       known_limit(ray_id, minimum), best);
            if (best.primitive != reference::kNone) record_hit(ray_id, best, hits, minimum);
        });
    }
}

/// The level kernel.
template <int Width>
void intersect_pairs(const Block& block, const reference::WideBvhView<Width>& bvh,
                     const reference::Ray* rays, const PairView& level, const HitView& hits,
                     const MinimumView& minimum, std::uint32_t grid_side) {
    BlockPairs loaded;
    BlockEntered entered;
    load_pairs(block, level, minimum, grid_side, loaded);
    test_pairs(block, bvh, rays, loaded, entered);
    append_pairs(block, bvh, loaded, entered, level);
    test_leaves(block, bvh, rays, loaded, entered, hits, minimum);
}

/// The last level that has a queue, if the tree goes on below it: each ray goes on from its node
/// alone, depth first.
template <int Width>
void intersect_pair_subtrees(const Block& block, const reference::WideBvhView<Width>& bvh,
                             const reference::Ray* rays, const PairView& level, const HitView& hits,
                             const MinimumView& minimum, std::uint32_t grid_side) {
    const bool any = minimum.policy != reference::EarlyOut::off && minimum.any_hit;
    BlockPairs loaded;
    load_pairs(block, level, minimum, grid_side, loaded);
    block.phase(loaded.count, [&](std::uint32_t thread) {
        const reference::HitCandidate best =
            reference::closest_in_subtree(bvh, loaded.node[thread], rays[loaded.ray[thread]],
                                          loaded.limit[thread], any)
                .best;
        if (best.primitive != reference::kNone) {
            record_hit(loaded.ray[thread], best, hits, minimum);
        }
    });
}

}  // namespace scotty::emulation
