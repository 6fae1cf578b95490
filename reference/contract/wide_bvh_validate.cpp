#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "reference/contract/wide_bvh.h"

namespace scotty::reference {
namespace {

constexpr std::size_t kMaxViolations = 20;

class Violations {
 public:
    template <typename... Args>
    void add(fmt::format_string<Args...> format, Args&&... args) {
        if (!full()) sentences_.push_back(fmt::format(format, std::forward<Args>(args)...));
    }
    bool full() const { return sentences_.size() >= kMaxViolations; }
    bool empty() const { return sentences_.empty(); }
    std::vector<std::string> take() { return std::move(sentences_); }

 private:
    std::vector<std::string> sentences_;
};

std::string text_of(const Vec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }
std::string text_of(const Bounds& box) { return text_of(box.low) + " to " + text_of(box.high); }

/// Exactly, and false where anything is not a number. Nothing is in every box.
bool contains(const Bounds& outer, const Bounds& inner) {
    const Bounds nothing;
    if (inner.low == nothing.low && inner.high == nothing.high) return true;
    return outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
           outer.high.x >= inner.high.x && outer.high.y >= inner.high.y &&
           outer.high.z >= inner.high.z;
}

template <int Width>
Bounds child_box(const WideNode<Width>& node, int i) {
    return {{node.low_x[i], node.low_y[i], node.low_z[i]},
            {node.high_x[i], node.high_y[i], node.high_z[i]}};
}

template <int Width>
Bounds own_box(const WideNode<Width>& node) {
    return {{node.low[0], node.low[1], node.low[2]}, {node.high[0], node.high[1], node.high[2]}};
}

/// Sizes and levels: what everything after relies on. False: going on would read out of bounds.
bool check_sizes(const WideBvh& bvh, std::size_t inner_count, Violations& found) {
    const std::size_t nodes = bvh.node_refs.size();
    if (nodes == 0 || inner_count == 0) {
        found.add("the tree has {} nodes and {} inner nodes, but at least one of each is expected",
                  nodes, inner_count);
    }
    if (inner_count + bvh.leaves.size() != nodes) {
        found.add("node_refs has {} entries, but there are {} inner nodes and {} leaves", nodes,
                  inner_count, bvh.leaves.size());
    }
    if (bvh.parents.size() != nodes) {
        found.add("parents has {} entries, but there are {} nodes", bvh.parents.size(), nodes);
    }
    const auto& begins = bvh.level_begins;
    // Nodes below the levels are those of subtrees.
    if (begins.size() < 2 || begins.front() != 0 || begins.back() > nodes) {
        found.add("level_begins has {} entries and does not run from 0 to at most {} nodes",
                  begins.size(), nodes);
    }
    for (std::size_t i = 1; i < begins.size(); ++i) {
        if (begins[i] <= begins[i - 1]) {
            found.add("level {} begins at node {} and ends at {}: it is empty", i - 1,
                      begins[i - 1], begins[i]);
        }
    }
    if (begins.size() >= 2 && begins[1] != 1) {
        found.add("level 0 has {} nodes, but the root is alone there", begins[1]);
    }
    return found.empty();
}

/// Every inner node and every leaf has one id.
void check_refs(const WideBvh& bvh, std::size_t inner_count, Violations& found) {
    std::vector<bool> inner_seen(inner_count);
    std::vector<bool> leaf_seen(bvh.leaves.size());
    for (std::size_t id = 0; id < bvh.node_refs.size(); ++id) {
        const std::uint32_t ref = bvh.node_refs[id];
        const char* kind = is_leaf(ref) ? "leaf" : "inner node";
        std::vector<bool>& seen = is_leaf(ref) ? leaf_seen : inner_seen;
        if (ref_index(ref) >= seen.size()) {
            found.add("node {}: refers to {} {}, but there are {}", id, kind, ref_index(ref),
                      seen.size());
        } else if (seen[ref_index(ref)]) {
            found.add("node {}: refers to {} {}, as another node does", id, kind, ref_index(ref));
        } else {
            seen[ref_index(ref)] = true;
        }
    }
    if (is_leaf(bvh.node_refs[0])) found.add("node 0: the root is a leaf, not an inner node");
}

std::vector<std::uint32_t> levels_of(const WideBvh& bvh) {
    std::vector<std::uint32_t> levels(bvh.node_count());
    for (std::uint32_t level = 0; level < bvh.level_count(); ++level) {
        for (std::uint32_t id = bvh.level_begins[level]; id < bvh.level_begins[level + 1]; ++id) {
            levels[id] = level;
        }
    }
    // Below the levels: one more than the parent's, if that is a node before it.
    for (std::uint32_t id = bvh.level_begins.back(); id < bvh.node_count(); ++id) {
        const std::uint32_t parent = bvh.parents[id];
        levels[id] = parent < id ? levels[parent] + 1 : kNone;
    }
    return levels;
}

/// Links between nodes: in range, one level down, known to both ends, each node reached once.
template <int Width>
void check_links(const WideBvh& bvh, const std::vector<WideNode<Width>>& inner, Violations& found) {
    const std::vector<std::uint32_t> levels = levels_of(bvh);
    std::vector<std::uint32_t> reached(bvh.node_count());
    const Bounds missing;
    for (std::uint32_t id = 0; id < bvh.node_count(); ++id) {
        if (is_leaf(bvh.node_refs[id])) continue;
        const WideNode<Width>& node = inner[ref_index(bvh.node_refs[id])];
        int children = 0;
        for (int i = 0; i < Width; ++i) {
            const std::uint32_t child = node.child[i];
            if (child == kNone) {
                const Bounds box = child_box(node, i);
                if (box.low != missing.low || box.high != missing.high) {
                    found.add("node {} child {}: is missing, but its box is {}", id, i,
                              text_of(box));
                }
                continue;
            }
            ++children;
            if (child >= bvh.node_count()) {
                found.add("node {} child {}: is node {}, but there are {}", id, i, child,
                          bvh.node_count());
                continue;
            }
            ++reached[child];
            if (levels[child] != levels[id] + 1) {
                found.add("node {} child {}: node {} is on level {}, its parent on level {}", id, i,
                          child, levels[child], levels[id]);
            }
            if (bvh.parents[child] != id) {
                found.add("node {} child {}: node {} names {} as its parent", id, i, child,
                          bvh.parents[child]);
            }
        }
        if (children == 0) found.add("node {}: has no children", id);
    }
    const std::uint32_t last = bvh.level_begins[bvh.level_count() - 1];
    for (std::uint32_t id = bvh.level_begins.back(); id < bvh.node_count(); ++id) {
        if (bvh.parents[id] < last) {
            found.add("node {}: is below the levels, but its parent {} is above the last of them",
                      id, bvh.parents[id]);
        }
    }
    if (bvh.parents[0] != kNone)
        found.add("node 0: the root names {} as its parent", bvh.parents[0]);
    for (std::uint32_t id = 0; id < bvh.node_count(); ++id) {
        const std::uint32_t expected = id == 0 ? 0 : 1;
        if (reached[id] != expected) {
            found.add("node {}: is the child of {} nodes, expected {}", id, reached[id], expected);
        }
    }
}

/// Leaves follow each other without a gap, and every triangle of the scene is in one, unchanged.
void check_leaves(const WideBvh& bvh, const Scene& scene, Violations& found) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < bvh.leaves.size(); ++i) {
        const Leaf& leaf = bvh.leaves[i];
        if (leaf.first != next || leaf.count == 0) {
            found.add("leaf {}: has {} triangles from {} on, expected some from {} on", i,
                      leaf.count, leaf.first, next);
        }
        next = std::size_t{leaf.first} + leaf.count;
        if (next > bvh.triangles.size()) {
            found.add("leaf {}: ends at triangle {}, but there are {}", i, next,
                      bvh.triangles.size());
        }
    }
    if (next != bvh.triangles.size()) {
        found.add("the leaves end at triangle {}, but there are {}", next, bvh.triangles.size());
    }
    std::vector<std::uint32_t> seen(scene.triangles.size());
    for (std::size_t i = 0; i < bvh.triangles.size(); ++i) {
        const LeafTriangle& triangle = bvh.triangles[i];
        if (triangle.primitive >= seen.size()) {
            found.add("triangle {}: is primitive {}, but the scene has {}", i, triangle.primitive,
                      seen.size());
            continue;
        }
        ++seen[triangle.primitive];
        const auto& index = scene.triangles[triangle.primitive];
        if (triangle.v0 != scene.vertices[index[0]] || triangle.v1 != scene.vertices[index[1]] ||
            triangle.v2 != scene.vertices[index[2]]) {
            found.add("triangle {}: its vertices are not those of primitive {}", i,
                      triangle.primitive);
        }
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (seen[i] != 1) found.add("primitive {}: is in {} leaves, expected 1", i, seen[i]);
    }
}

Bounds united(const Bounds& a, const Bounds& b) {
    return {min_of(a.low, b.low), max_of(a.high, b.high)};
}

/// Boxes from the leaves upwards; children have higher ids than their parents by now.
template <int Width>
void check_boxes(const WideBvh& bvh, const std::vector<WideNode<Width>>& inner, Violations& found) {
    std::vector<Bounds> below(bvh.node_count());
    for (std::uint32_t id = bvh.node_count(); id-- > 0;) {
        const std::uint32_t index = ref_index(bvh.node_refs[id]);
        if (is_leaf(bvh.node_refs[id])) {
            const Leaf& leaf = bvh.leaves[index];
            for (std::uint32_t k = leaf.first; k < leaf.first + leaf.count; ++k) {
                const LeafTriangle& triangle = bvh.triangles[k];
                for (const Vec3& vertex : {triangle.v0, triangle.v1, triangle.v2}) {
                    below[id] = united(below[id], {vertex, vertex});
                }
            }
            continue;
        }
        const WideNode<Width>& node = inner[index];
        for (int i = 0; i < Width; ++i) {
            if (node.child[i] == kNone) continue;
            const Bounds box = child_box(node, i);
            const Bounds& vertices = below[node.child[i]];
            if (!contains(box, vertices)) {
                found.add("node {} child {}: its box {} does not contain the vertices below, {}",
                          id, i, text_of(box), text_of(vertices));
            }
            if (!contains(own_box(node), box)) {
                found.add("node {} child {}: its box {} is not within the node's own, {}", id, i,
                          text_of(box), text_of(own_box(node)));
            }
            below[id] = united(below[id], vertices);
        }
    }
}

template <int Width>
void check_tree(const WideBvh& bvh, const std::vector<WideNode<Width>>& inner, const Scene& scene,
                Violations& found) {
    if (bvh.width != Width) {
        found.add("width says {}, but the nodes have {} children", bvh.width, Width);
    }
    // Each step relies on the one before: a broken link is not followed to its boxes.
    if (!check_sizes(bvh, inner.size(), found)) return;
    check_refs(bvh, inner.size(), found);
    if (!found.empty()) return;
    check_links(bvh, inner, found);
    check_leaves(bvh, scene, found);
    if (found.empty()) check_boxes(bvh, inner, found);
}

}  // namespace

std::vector<std::string> validate(const WideBvh& bvh, const Scene& scene) {
    Violations found;
    std::visit([&](const auto& inner) { check_tree(bvh, inner, scene, found); }, bvh.inner);
    return found.take();
}

}  // namespace scotty::reference
