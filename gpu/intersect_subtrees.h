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
    const std::uint32_t total = level.block_offsets[level.node_count];
    if (level.faults->queue_needed != 0) SCOTTY_RETURN;
    const bool any = minimum.culls != 0 && minimum.any_hit != 0;
    const SubtreeAccess<Width> access{bvh};
    const std::uint32_t side = strided ? side_of_grid(total) : 0;
    const std::uint32_t launched_blocks = strided ? side * side : total;
    for (std::uint32_t launched = block_index(); launched < launched_blocks;
         launched += grid_size()) {
        const std::uint32_t id = strided ? launched % side * side + launched / side : launched;
        if (id >= total) continue;
        const std::uint32_t node =
            SCOTTY_AWAIT(find_node(level.block_offsets, level.node_count, id));
        const std::uint32_t entry =
            (id - level.block_offsets[node]) * block_size() + thread_index();
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
