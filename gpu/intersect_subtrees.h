/// Kernel: the last level that has queues, where that is not the last of the tree. Each ray goes on
/// from its node alone, depth first.
#pragma once

#include "gpu/dialect.h"
#include "gpu/intersect.h"
#include "gpu/subtree_refs.h"
#include "gpu/views.h"
#include "reference/closest_in_subtree.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// What reference/closest_in_subtree.h asks of a BVH.
template <int Width>
struct SubtreeAccess {
    BvhView<Width> bvh;

    template <class Record>
    SCOTTY_DEVICE Record load(const Record* record) const {
        return load_record(record);
    }
    SCOTTY_DEVICE const reference::WideNode<Width>* node(std::uint32_t ref) const {
        return bvh.inner + ref;
    }
    SCOTTY_DEVICE std::uint32_t child_ref(const reference::WideNode<Width>* node,
                                          std::uint32_t child) const {
        return node->child[child];  // a reference already: DeviceScene
    }
    SCOTTY_DEVICE reference::Leaf leaf(std::uint32_t ref) const {
        return bvh.packed_leaves != 0 ? unpacked_leaf(ref) : bvh.leaves[reference::ref_index(ref)];
    }
    SCOTTY_DEVICE const reference::LeafTriangle* triangles() const { return bvh.triangles; }
};

/// At level 0 (`level.queue` is null) a ray's id is its place, and its traversal begins here.
template <int Width>
SCOTTY_KERNEL(intersect_subtrees)
(BvhView<Width> bvh, const reference::Ray* rays, LevelView level, HitView hits, MinimumView minimum,
 bool strided) {
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    const bool any = minimum.culls != 0 && minimum.any_hit != 0;
    const SubtreeAccess<Width> access{bvh};
    const BlockGrid grid = block_grid(level, strided);
    for (std::uint32_t launched = block_index(); launched < grid.launched;
         launched += grid_size()) {
        const std::uint32_t id = logical_block(grid, launched);
        if (id >= grid.total) continue;
        const auto [node, entry] = SCOTTY_AWAIT(find_work(level, id));
        if (entry >= level.node_counts[node]) continue;
        const bool first = level.queue == nullptr;
        const std::uint32_t ray_id = first ? entry : level.queue[level.queue_offsets[node] + entry];
        const reference::Ray ray = load_record(rays + ray_id);
        if (first) begin_ray(ray_id, ray, hits, minimum);
        const std::uint32_t ref = bvh.node_refs[level.first_node + node];
        const bool packs = reference::is_leaf(ref) && bvh.packed_leaves != 0;
        const reference::HitCandidate best = reference::closest_in_subtree<Width>(
            access, packs ? packed_leaf(bvh.leaves[reference::ref_index(ref)]) : ref, ray,
            limit_of(ray_id, ray, first, minimum), any);
        if (best.primitive != reference::kNone) record_hit(ray_id, best, hits, minimum);
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
