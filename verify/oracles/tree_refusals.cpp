#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "verify/oracles/refusal_check.h"

namespace scotty::verify {

using reference::kNone;
using reference::WideBvh;
using reference::WideNode;

namespace {

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

class TreeSpoiler {
 public:
    TreeSpoiler(const WideBvh& bvh, const reference::Scene& scene, const TreeValidator& validator,
                std::string* said)
        : bvh_(bvh), scene_(scene), validator_(validator), said_(said) {}

    std::vector<Failure> run() {
        spoil_tables();
        for (const std::size_t i : some(bvh_.node_refs.size())) spoil_ref(i);
        for (const std::size_t i : some(bvh_.leaves.size())) spoil_leaf(i);
        for (const std::size_t i : some(bvh_.triangles.size())) spoil_triangle(i);
        std::visit([&](const auto& inner) { spoil_nodes(inner); }, bvh_.inner);
        return std::move(failures_);
    }

 private:
    using Edit = std::function<void(WideBvh&)>;

    static std::set<std::size_t> some(std::size_t size) {
        if (size == 0) return {};
        return {0, size / 2, size - 1};
    }

    void refused(const std::string& what, const Edit& edit) {
        WideBvh copy = bvh_;
        edit(copy);
        const std::vector<std::string> found = validator_(copy, scene_);
        if (said_ != nullptr) *said_ += fmt::format("{}\n", fmt::join(found, "\n"));
        if (!found.empty()) return;
        Failure failure;
        failure.invariant = kRefusal;
        failure.stage = "tree";
        failure.field = what;
        failure.sentence = what + ": the tree is taken for valid";
        failures_.push_back(std::move(failure));
    }

    void spoil_tables() {
        refused("another width", [](WideBvh& b) { b.width *= 2; });
        refused("a node without a parent entry", [](WideBvh& b) { b.parents.pop_back(); });
        refused("a parent entry of no node", [](WideBvh& b) { b.parents.push_back(0); });
        refused("a node less", [](WideBvh& b) {
            b.node_refs.pop_back();
            b.parents.pop_back();
        });
        refused("no nodes", [](WideBvh& b) {
            b.node_refs.clear();
            b.parents.clear();
        });
        refused("a leaf less", [](WideBvh& b) { b.leaves.pop_back(); });
        refused("a triangle less", [](WideBvh& b) { b.triangles.pop_back(); });
        refused("a triangle twice", [](WideBvh& b) { b.triangles.push_back(b.triangles.front()); });
        refused("no levels", [](WideBvh& b) { b.level_begins.clear(); });
        refused("one bound of levels", [](WideBvh& b) { b.level_begins.resize(1); });
        refused("an empty level",
                [](WideBvh& b) { b.level_begins.push_back(b.level_begins.back()); });
        refused("a level that ends past the nodes", [](WideBvh& b) { ++b.level_begins.back(); });
        for (std::size_t i = 0; i + 1 < bvh_.level_begins.size(); ++i) {
            refused(fmt::format("level {} begins one node later", i),
                    [=](WideBvh& b) { ++b.level_begins[i]; });
        }
        refused("a root with a parent", [](WideBvh& b) { b.parents[0] = 0; });
    }

    void spoil_ref(std::size_t i) {
        const auto to = [&](std::uint32_t value) {
            refused(fmt::format("node {} refers to {:#x}", i, value),
                    [=](WideBvh& b) { b.node_refs[i] = value; });
        };
        const std::uint32_t ref = bvh_.node_refs[i];
        const std::size_t kin = reference::is_leaf(ref) ? bvh_.leaves.size() : bvh_.inner_count();
        to(ref ^ reference::kLeafBit);
        to((ref & reference::kLeafBit) | static_cast<std::uint32_t>(kin));
        if (kin > 1) {
            const std::uint32_t index = reference::ref_index(ref);
            to((ref & reference::kLeafBit) | (index == 0 ? 1 : index - 1));
        }
        if (i == 0) return;
        const std::uint32_t parent = bvh_.parents[i];
        for (const std::uint32_t other : {parent + 1, parent - 1, 0u, kNone, bvh_.node_count()}) {
            if (other == parent) continue;
            refused(fmt::format("node {} has the parent {}", i, other),
                    [=](WideBvh& b) { b.parents[i] = other; });
        }
    }

    void spoil_leaf(std::size_t i) {
        refused(fmt::format("leaf {} begins one later", i),
                [=](WideBvh& b) { ++b.leaves[i].first; });
        refused(fmt::format("leaf {} has one more", i), [=](WideBvh& b) { ++b.leaves[i].count; });
        refused(fmt::format("leaf {} has one less", i), [=](WideBvh& b) { --b.leaves[i].count; });
    }

    void spoil_triangle(std::size_t i) {
        const auto count = static_cast<std::uint32_t>(scene_.triangles.size());
        const std::uint32_t primitive = bvh_.triangles[i].primitive;
        refused(fmt::format("triangle {} is a primitive beyond the last", i),
                [=](WideBvh& b) { b.triangles[i].primitive = count; });
        if (count > 1) {
            refused(fmt::format("triangle {} is another's primitive", i), [=](WideBvh& b) {
                b.triangles[i].primitive = primitive == 0 ? 1 : primitive - 1;
            });
        }
        for (int axis = 0; axis < 3; ++axis) {
            for (auto corner : {&reference::LeafTriangle::v0, &reference::LeafTriangle::v1,
                                &reference::LeafTriangle::v2}) {
                refused(fmt::format("triangle {} has a corner that moved", i), [=](WideBvh& b) {
                    float& value = (b.triangles[i].*corner)[axis];
                    value = std::nextafter(value, reference::kInfinity);
                });
            }
        }
    }

    /// Of the triangles below a node.
    reference::Bounds vertices_below(std::uint32_t id) const {
        reference::Bounds box;
        const auto add = [&](const reference::Bounds& more) {
            box.low = reference::min_of(box.low, more.low);
            box.high = reference::max_of(box.high, more.high);
        };
        if (reference::is_leaf(bvh_.node_refs[id])) {
            const reference::Leaf& leaf = bvh_.leaves[reference::ref_index(bvh_.node_refs[id])];
            for (std::uint32_t k = leaf.first; k < leaf.first + leaf.count; ++k) {
                const reference::LeafTriangle& t = bvh_.triangles[k];
                for (const auto& vertex : {t.v0, t.v1, t.v2}) add({vertex, vertex});
            }
            return box;
        }
        for (std::uint32_t child = id + 1; child < bvh_.node_count(); ++child) {
            if (bvh_.parents[child] == id) add(vertices_below(child));
        }
        return box;
    }

    template <int Width>
    void spoil_nodes(const std::vector<WideNode<Width>>& inner) {
        for (const std::size_t n : some(inner.size())) {
            for (int i = 0; i < Width; ++i) spoil_child<Width>(n, i, inner[n].child[i]);
        }
    }

    template <int Width>
    void spoil_child(std::size_t n, int i, std::uint32_t child) {
        using Node = WideNode<Width>;
        const auto edit = [&](const std::string& what, const std::function<void(Node&)>& spoil) {
            refused(fmt::format("inner node {} child {} {}", n, i, what),
                    [&](WideBvh& b) { spoil(std::get<std::vector<Node>>(b.inner)[n]); });
        };
        const auto sides = {std::pair{&Node::low_x, &Node::high_x},
                            {&Node::low_y, &Node::high_y},
                            {&Node::low_z, &Node::high_z}};
        if (child == kNone) {
            edit("is missing and has a box", [&](Node& node) { node.low_x[i] = 0.0f; });
            edit("is missing and has a box", [&](Node& node) { node.high_z[i] = 0.0f; });
            return;
        }
        edit("is a node that is not there", [&](Node& node) { node.child[i] = bvh_.node_count(); });
        edit("is missing and has a box", [&](Node& node) { node.child[i] = kNone; });
        edit("is the root", [&](Node& node) { node.child[i] = 0; });
        const reference::Bounds tight = vertices_below(child);
        int axis = 0;
        for (const auto& [low, high] : sides) {
            edit("has a lower side that cuts a vertex", [&, side = low](Node& node) {
                (node.*side)[i] = std::nextafter(tight.low[axis], reference::kInfinity);
            });
            edit("has an upper side that cuts a vertex", [&, side = high](Node& node) {
                (node.*side)[i] = std::nextafter(tight.high[axis], -reference::kInfinity);
            });
            edit("has a lower side that is no number",
                 [&, side = low](Node& node) { (node.*side)[i] = kNoNumber; });
            edit("has an upper side that is no number",
                 [&, side = high](Node& node) { (node.*side)[i] = kNoNumber; });
            edit("has a lower side outside the node's box", [&, side = low](Node& node) {
                (node.*side)[i] = std::nextafter(node.low[axis], -reference::kInfinity);
            });
            edit("has an upper side outside the node's box", [&, side = high](Node& node) {
                (node.*side)[i] = std::nextafter(node.high[axis], reference::kInfinity);
            });
            ++axis;
        }
    }

    const WideBvh& bvh_;
    const reference::Scene& scene_;
    const TreeValidator& validator_;
    std::string* said_;
    std::vector<Failure> failures_;
};

}  // namespace

std::vector<Failure> check_tree_refusals(const WideBvh& bvh, const reference::Scene& scene,
                                         const TreeValidator& validator, std::string* said) {
    return TreeSpoiler(bvh, scene, validator, said).run();
}

}  // namespace scotty::verify
