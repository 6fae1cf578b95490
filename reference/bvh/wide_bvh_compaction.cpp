#include "reference/bvh/wide_bvh_compaction.h"

#include <algorithm>
#include <limits>

namespace scotty::reference {
namespace {

/// Added to every relative area, so that of nodes without area the fewest are made.
constexpr double kLeastArea = 1.0e-9;

/// [i]: the least cost of a subtree as at most i nodes, i from 1 on.
using Costs = std::array<double, kMaxWidth + 1>;

/// The left subtree as k nodes and the right one as i - k: the best k and what it costs.
struct Split {
    std::uint8_t left;
    double cost;
};
Split best_split(const Costs& left, const Costs& right, int i) {
    Split best{1, std::numeric_limits<double>::infinity()};
    for (int k = 1; k < i; ++k) {
        const double cost = left[k] + right[i - k];
        if (cost < best.cost) best = {static_cast<std::uint8_t>(k), cost};
    }
    return best;
}

}  // namespace

Compaction::Compaction(const BinaryBvh& binary, int width, int max_leaf_size)
    : binary_(binary),
      width_(width),
      row_size_(static_cast<std::size_t>(width) + 1),
      choices_(binary.nodes.size() * row_size_) {
    const double root_area = half_area(binary.nodes.front());
    const double scale = root_area > 0.0 ? 1.0 / root_area : 0.0;
    // Backwards through depth-first order, a node finds its children's costs on top of a stack:
    // the left child's, just done, above the right one's.
    std::vector<Costs> stack;
    for (std::size_t id = binary.nodes.size(); id-- > 0;) {
        const BinaryNode& node = binary.nodes[id];
        const double area = half_area(node) * scale + kLeastArea;
        std::uint8_t* choice = choices_.data() + id * row_size_;
        const double as_leaf = area * (kLeafCost + kTriangleCost * node.count);
        Costs costs;
        if (node.right == kNone) {
            choice[0] = 1;
            costs.fill(as_leaf);
            stack.push_back(costs);
            continue;
        }
        const Costs left = stack.back();
        stack.pop_back();
        const Costs right = stack.back();
        const Split inner = best_split(left, right, width);
        const double as_inner = area * kNodeCost + inner.cost;
        const bool leaf =
            node.count <= static_cast<std::uint32_t>(max_leaf_size) && as_leaf <= as_inner;
        choice[0] = leaf ? 1 : 0;
        choice[1] = inner.left;
        costs[1] = leaf ? as_leaf : as_inner;
        for (int i = 2; i <= width; ++i) {
            const Split split = best_split(left, right, i);
            const bool better = split.cost < costs[i - 1];
            choice[i] = better ? split.left : std::uint8_t{0};
            costs[i] = better ? split.cost : costs[i - 1];
        }
        stack.back() = costs;
    }
    cost_ = stack.back()[1];
}

/// Recursion is at most `width` deep: each step hands fewer nodes on.
int Compaction::collect(std::uint32_t node, int roots, std::uint32_t* out) const {
    const std::uint8_t* choice = row(node);
    const bool single = binary_.nodes[node].right == kNone;
    while (roots > 1 && (single || choice[roots] == 0)) --roots;
    if (roots == 1) {
        *out = node;
        return 1;
    }
    const int left = collect(node + 1, choice[roots], out);
    return left + collect(binary_.nodes[node].right, roots - choice[roots], out + left);
}

int Compaction::children(std::uint32_t node, std::array<std::uint32_t, kMaxWidth>& out) const {
    const int from_left = row(node)[1];
    const int left = collect(node + 1, from_left, out.data());
    return left + collect(binary_.nodes[node].right, width_ - from_left, out.data() + left);
}

}  // namespace scotty::reference
