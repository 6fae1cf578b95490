/// What reference/closest_in_subtree.h asks of a BVH, on the device.
#pragma once

#include "gpu/dialect.h"
#include "gpu/subtree_refs.h"
#include "gpu/views.h"
#include "reference/records.h"

namespace SCOTTY_DEVICE_NAMESPACE {

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
    /// A node of the last level that has queues; leaves are packed as they are below it.
    SCOTTY_DEVICE std::uint32_t root(std::uint32_t node) const {
        const std::uint32_t ref = bvh.node_refs[node];
        const bool packs = reference::is_leaf(ref) && bvh.packed_leaves != 0;
        return packs ? packed_leaf(bvh.leaves[reference::ref_index(ref)]) : ref;
    }
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
