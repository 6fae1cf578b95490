#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/gltf_parts.h"

namespace scotty::scenes {

namespace {

constexpr std::uint64_t kNoParent = ~std::uint64_t{0};

Affine from_matrix(const GltfObject& node) {
    const auto columns = node.numbers<16>("matrix", {});
    std::array<double, 16> rows{};
    for (std::size_t k = 0; k < 16; ++k) rows[k] = columns[k % 4 * 4 + k / 4];
    if (const auto affine = affine_of_rows(rows)) return *affine;
    throw node.error(fmt::format("matrix: expected a last row of 0 0 0 1, found {} {} {} {}",
                                 rows[12], rows[13], rows[14], rows[15]));
}

Affine from_parts(const GltfObject& node) {
    const auto move = node.numbers<3>("translation", {0, 0, 0});
    const auto scale = node.numbers<3>("scale", {1, 1, 1});
    auto [x, y, z, w] = node.numbers<4>("rotation", {0, 0, 0, 1});
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(norm > 0.0) || !std::isfinite(norm)) {
        throw node.error(
            fmt::format("rotation: expected a unit quaternion, found {} {} {} {}", x, y, z, w));
    }
    x /= norm;
    y /= norm;
    z /= norm;
    w /= norm;
    Affine out;
    out.m = {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), move[0]},
              {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), move[1]},
              {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), move[2]}}};
    for (auto& row : out.m) {
        for (std::size_t c = 0; c < 3; ++c) row[c] *= scale[c];
    }
    return out;
}

Affine local_transform(const GltfObject& node, Notes& notes) {
    if (!node.has("matrix")) return from_parts(node);
    if (node.has("translation") || node.has("rotation") || node.has("scale")) {
        notes.add("a node with both a matrix and its parts: the matrix is used");
    }
    return from_matrix(node);
}

}  // namespace

void GltfNodes::find_parents(const std::vector<GltfObject>& nodes) {
    parent_.assign(nodes.size(), kNoParent);
    for (const GltfObject& node : nodes) {
        children_.push_back(node.wholes("children"));
        const std::uint64_t index = children_.size() - 1;
        for (const std::uint64_t child : children_.back()) {
            if (child >= nodes.size()) {
                throw node.error(
                    fmt::format("child {} out of range, there are {} nodes", child, nodes.size()));
            }
            if (parent_[child] != kNoParent) throw nodes[child].error("is the child of two nodes");
            parent_[child] = index;
        }
    }
}

/// With one parent at most, a node that no parentless node leads to lies in a circle or below one.
void GltfNodes::check_circles(const std::vector<GltfObject>& nodes) const {
    std::vector<bool> is_reached(nodes.size(), false);
    std::vector<std::uint64_t> open;
    for (std::uint64_t i = 0; i < nodes.size(); ++i) {
        if (parent_[i] == kNoParent) open.push_back(i);
    }
    while (!open.empty()) {
        const std::uint64_t node = open.back();
        open.pop_back();
        is_reached[node] = true;
        open.insert(open.end(), children_[node].begin(), children_[node].end());
    }
    const auto missed = std::find(is_reached.begin(), is_reached.end(), false);
    if (missed == is_reached.end()) return;
    throw nodes[static_cast<std::size_t>(missed - is_reached.begin())].error(
        "is a node below itself: nodes are in a circle");
}

std::vector<std::uint64_t> GltfNodes::roots(const GltfDocument& document, Notes& notes) const {
    const GltfObject root = document.root();
    const std::size_t scenes = root.length("scenes");
    std::vector<std::uint64_t> out;
    if (scenes == 0 && !root.has("scene")) {
        for (std::uint64_t i = 0; i < parent_.size(); ++i) {
            if (parent_[i] == kNoParent) out.push_back(i);
        }
        return out;
    }
    const GltfObject scene = root.at("scenes", root.whole("scene", 0), root);
    if (scenes > 1 && !root.has("scene")) {
        notes.add("the file does not say which of its scenes is shown: the first");
    }
    notes.add("a further scene in the file: not shown", scenes - 1);
    std::vector<bool> is_listed(parent_.size(), false);
    for (const std::uint64_t node : scene.wholes("nodes")) {
        if (node >= parent_.size()) {
            throw scene.error(
                fmt::format("node {} out of range, there are {} nodes", node, parent_.size()));
        }
        if (parent_[node] != kNoParent) {
            throw scene.error(
                fmt::format("node {} is no root: it is a child of node {}", node, parent_[node]));
        }
        if (is_listed[node]) throw scene.error(fmt::format("node {} is listed twice", node));
        is_listed[node] = true;
        out.push_back(node);
    }
    return out;
}

void GltfNodes::place_below(std::uint64_t root, const std::vector<GltfObject>& nodes,
                            Notes& notes) {
    std::vector<Placed> open = {{root, Affine{}}};  // places of the parents
    while (!open.empty()) {
        Placed node = open.back();
        open.pop_back();
        node.place = node.place * local_transform(nodes[node.index], notes);
        placed_.push_back(node);
        const auto& children = children_[node.index];
        std::for_each(children.rbegin(), children.rend(), [&](std::uint64_t child) {
            open.push_back({child, node.place});
        });
    }
}

GltfNodes::GltfNodes(const GltfDocument& document, Notes& notes) {
    const auto nodes = document.root().objects("nodes");
    find_parents(nodes);
    check_circles(nodes);
    for (const std::uint64_t root : roots(document, notes)) place_below(root, nodes, notes);
    number_in_placed_.assign(nodes.size(), kNoParent);
    for (std::size_t i = 0; i < placed_.size(); ++i) number_in_placed_[placed_[i].index] = i;
}

const Affine* GltfNodes::place_of(std::uint64_t node) const {
    const bool is_placed =
        node < number_in_placed_.size() && number_in_placed_[node] < placed_.size();
    return is_placed ? &placed_[number_in_placed_[node]].place : nullptr;
}

}  // namespace scotty::scenes
