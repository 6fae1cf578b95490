/// Which nodes of a binary BVH become the nodes of a wide one. Internal to reference/.
///
/// Optimal by the surface-area heuristic, by dynamic programming: Ylitie, Karras, Laine, "Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1. Held
/// against the greedy rule of Wald et al. 2008 (open the child with the largest area until there
/// are N) on full leaves of four, width 8, it enters about as many nodes and tests a quarter to a
/// half fewer triangles, because leaves and nodes are chosen together.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reference/bvh/binary_bvh.h"

namespace scotty::reference {

/// What a ray pays, in node visits: all children of a node are tested at once.
constexpr double kNodeCost = 1.0;
constexpr double kLeafCost = 0.5;  ///< to be queued at a leaf at all
constexpr double kTriangleCost = 0.1;

constexpr int kMaxWidth = 16;

class Compaction {
 public:
    /// Keeps a reference to `binary`. Takes (width + 1) bytes a binary node.
    Compaction(const BinaryBvh& binary, int width, int max_leaf_size);

    /// Whether a binary node that is the child of a wide node, or the root, becomes a leaf.
    bool is_leaf(std::uint32_t node) const { return row(node)[0] != 0; }
    /// Binary nodes that become the children of `node`, in depth-first order (neighbours are near
    /// each other); returns how many. Requires !is_leaf(node).
    int children(std::uint32_t node, std::array<std::uint32_t, kMaxWidth>& out) const;
    /// Expected cost of a ray that enters the root, in node visits.
    double cost() const { return cost_; }

 private:
    const std::uint8_t* row(std::uint32_t node) const {
        return choices_.data() + static_cast<std::size_t>(node) * row_size_;
    }
    int collect(std::uint32_t node, int roots, std::uint32_t* out) const;

    const BinaryBvh& binary_;
    int width_;
    std::size_t row_size_;
    /// A row a node. [0]: 1 where it is a leaf. [1]: of the `width` children it may have as a wide
    /// node, how many come from its left. [i], i > 1: the same where it is to be replaced by at
    /// most i nodes below; 0: replacing it by fewer is no worse.
    std::vector<std::uint8_t> choices_;
    double cost_ = 0.0;
};

}  // namespace scotty::reference
