/// Children of subtree nodes on the device: references in place of node ids, which saves a load
/// for each node visited, and leaves that hold their range of triangles, which saves another.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/dialect.h"
#include "reference/host_device.h"
#include "reference/wide_bvh.h"

namespace SCOTTY_DEVICE_NAMESPACE {

// A packed leaf: kLeafBit, six bits of count - 1, 25 bits of its first triangle.
constexpr std::uint32_t kFirstBits = 25;
constexpr std::uint32_t kMostInLeaf = 64;

SCOTTY_HD std::uint32_t packed_leaf(const reference::Leaf& leaf) {
    return reference::kLeafBit | (leaf.count - 1) << kFirstBits | leaf.first;
}
SCOTTY_HD reference::Leaf unpacked_leaf(std::uint32_t ref) {
    return {ref & ((1u << kFirstBits) - 1), (ref >> kFirstBits & (kMostInLeaf - 1)) + 1};
}

/// Whether all of a BVH's leaves can be packed.
inline bool can_pack(const reference::WideBvh& bvh) {
    if (bvh.triangles.size() >= std::size_t{1} << kFirstBits) return false;
    for (const reference::Leaf& leaf : bvh.leaves) {
        if (leaf.count > kMostInLeaf) return false;
    }
    return true;
}

/// Replaces the children of all inner nodes from the last level on. Those of the levels above are
/// ids, as queues need them.
template <int Width>
void make_subtree_refs(const reference::WideBvh& bvh, bool packed,
                       std::vector<reference::WideNode<Width>>& inner) {
    for (std::uint32_t id = bvh.level_begins[bvh.level_count() - 1]; id < bvh.node_count(); ++id) {
        const std::uint32_t own = bvh.node_refs[id];
        if (reference::is_leaf(own)) continue;
        for (std::uint32_t& child : inner[reference::ref_index(own)].child) {
            if (child == reference::kNone) continue;
            const std::uint32_t ref = bvh.node_refs[child];
            child = packed && reference::is_leaf(ref)
                        ? packed_leaf(bvh.leaves[reference::ref_index(ref)])
                        : ref;
        }
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
