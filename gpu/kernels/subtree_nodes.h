/// Nodes and triangles as rays below the queues read them: in few loads and few selections.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/kernels/dialect.h"
#include "reference/contract/wide_bvh.h"
#include "reference/numerics/closest_in_subtree.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// One plane of each child's box, on one axis.
template <int Width>
struct alignas(Width == 2 ? 8 : 16) ChildPlanes {
    float at[Width];
};

/// An inner node below the queues. On each axis the children's low planes stand beside their high
/// ones, so that the address of the planes that a ray leaves by is that of the planes it enters by
/// with one bit flipped. A child is a reference: an inner node's index in this array, or kLeafBit
/// and the first triangle of a leaf.
template <int Width>
struct alignas(32 * Width) SubtreeNode {
    ChildPlanes<Width> planes[3][2];  ///< by axis: low, high
    std::uint32_t child[Width];       ///< kNone where there is none
};
/// The length of a node in sets of planes.
constexpr std::uint32_t kPlanesInNode = 8;
static_assert(sizeof(SubtreeNode<4>) == kPlanesInNode * sizeof(ChildPlanes<4>));

/// One coordinate of a triangle's corners. By its address, rays read the axis of their largest
/// direction component as the last one (reference::swap_axes).
struct alignas(16) TriangleRow {
    float v0, v1, v2;
    std::uint32_t primitive_and_last;  ///< kLastBit marks the last triangle of a leaf
};
constexpr std::uint32_t kLastBit = 0x80000000u;

struct TriangleRows {
    TriangleRow axis[3];

    SCOTTY_HD std::uint32_t primitive() const { return axis[0].primitive_and_last & ~kLastBit; }
};
static_assert(sizeof(TriangleRows) == 48, "three 16-byte loads");

inline TriangleRows rows_of(const reference::LeafTriangle& t) {
    return {{{t.v0.x, t.v1.x, t.v2.x, t.primitive},
             {t.v0.y, t.v1.y, t.v2.y, t.primitive},
             {t.v0.z, t.v1.z, t.v2.z, t.primitive}}};
}

/// In leaf order, as in the BVH.
inline std::vector<TriangleRows> triangle_rows(const reference::WideBvh& bvh) {
    std::vector<TriangleRows> rows;
    rows.reserve(bvh.triangles.size());
    for (const reference::LeafTriangle& triangle : bvh.triangles) rows.push_back(rows_of(triangle));
    for (const reference::Leaf& leaf : bvh.leaves) {
        for (TriangleRow& row : rows[leaf.first + leaf.count - 1].axis) {
            row.primitive_and_last |= kLastBit;
        }
    }
    return rows;
}

/// The inner nodes from the last level with queues on, whose nodes are the roots of the subtrees;
/// empty if there are none. Node i is the BVH's inner node `first_inner` + i.
template <int Width>
std::vector<SubtreeNode<Width>> subtree_nodes(const reference::WideBvh& bvh,
                                              const std::vector<reference::WideNode<Width>>& inner,
                                              std::uint32_t first_inner) {
    std::vector<SubtreeNode<Width>> nodes(inner.size() - first_inner);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const reference::WideNode<Width>& from = inner[first_inner + i];
        const float* const planes[3][2] = {
            {from.low_x, from.high_x}, {from.low_y, from.high_y}, {from.low_z, from.high_z}};
        for (int child = 0; child < Width; ++child) {
            for (int axis = 0; axis < 3; ++axis) {
                for (int side = 0; side < 2; ++side) {
                    nodes[i].planes[axis][side].at[child] = planes[axis][side][child];
                }
            }
            const std::uint32_t id = from.child[child];
            std::uint32_t& to = nodes[i].child[child];
            to = reference::kNone;
            if (id == reference::kNone) continue;
            const std::uint32_t ref = bvh.node_refs[id];
            to = reference::is_leaf(ref)
                     ? reference::kLeafBit | bvh.leaves[reference::ref_index(ref)].first
                     : ref - first_inner;
        }
    }
    return nodes;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
