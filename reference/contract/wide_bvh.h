/// The N-way BVH that every pipeline traverses level by level.
///
/// Built in four steps, all deterministic: a binary BVH by Embree's builder; *reinsertion* of its
/// subtrees where they cost less (reinsertion.h); *compaction* to N children a node
/// (wide_bvh_compaction.h); *serialisation* to indices in breadth-first order.
///
/// Node ids are breadth-first positions, so a level is a contiguous range of ids and the children
/// of one node are neighbours. An id is looked up in node_refs: an inner node or a leaf.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::reference {

struct BvhParameters {
    int width = 8;            ///< 2, 4, 8 or 16
    int max_leaf_size = 4;    ///< triangles per leaf at most, 1..1024; fewer where that is cheaper
    std::size_t threads = 0;  ///< 0: all. The result does not depend on it.
    std::uint32_t queue_levels = 0;  ///< see cut_levels(); 0: all
};

BvhParameters bvh_parameters(const PipelineParameters& parameters, std::size_t threads);

/// Throws bad_input naming the parameter.
void validate(const BvhParameters& parameters);

/// A BVH of one width. `inner` holds the vector of the width that was asked for.
struct WideBvh {
    int width = 0;
    std::variant<std::vector<WideNode<2>>, std::vector<WideNode<4>>, std::vector<WideNode<8>>,
                 std::vector<WideNode<16>>>
        inner;
    std::vector<Leaf> leaves;
    std::vector<LeafTriangle> triangles;   ///< in leaf order; each scene triangle exactly once
    std::vector<std::uint32_t> node_refs;  ///< by node id: kLeafBit | leaf index, or inner index
    std::vector<std::uint32_t> parents;    ///< by node id: the parent's id; kNone at the root
    /// Level l is ids [begins[l], begins[l + 1]). Only levels that have queues are here: nodes from
    /// the last entry on belong to subtrees that rays traverse depth first (cut_levels()).
    std::vector<std::uint32_t> level_begins;

    std::uint32_t node_count() const { return static_cast<std::uint32_t>(node_refs.size()); }
    std::uint32_t level_count() const {
        return static_cast<std::uint32_t>(level_begins.size() - 1);
    }
    std::uint32_t inner_count() const;
    /// There are nodes below the levels: inner nodes of the last one are subtrees (cut_levels()).
    bool has_subtrees() const { return level_begins.back() < node_count(); }
    bool is_level_of_subtrees(std::uint32_t level) const {
        return has_subtrees() && level + 1 == level_count();
    }
    /// Rays in its queue are not pushed on: a leaf, or the root of a subtree (cut_levels()).
    bool ends_queues(std::uint32_t node) const {
        return is_leaf(node_refs[node]) || node >= level_begins[level_count() - 1];
    }
};

/// Plain pointers into a WideBvh, for kernels.
template <int Width>
struct WideBvhView {
    const WideNode<Width>* inner = nullptr;
    const Leaf* leaves = nullptr;
    const LeafTriangle* triangles = nullptr;
    const std::uint32_t* node_refs = nullptr;
};
/// Requires bvh.width == Width.
template <int Width>
WideBvhView<Width> view_of(const WideBvh& bvh) {
    return {std::get<std::vector<WideNode<Width>>>(bvh.inner).data(), bvh.leaves.data(),
            bvh.triangles.data(), bvh.node_refs.data()};
}

/// Builds the BVH of all triangles of a validated scene (at least one triangle). The root is
/// always node 0; a scene that fits one leaf has a root that is an inner node with one child, so
/// that level 0 is always one inner node. No limit on levels, nodes a level or leaf size.
WideBvh build_wide_bvh(const Scene& scene, const BvhParameters& parameters);

/// Leaves only the first `queue_levels` levels as levels: an inner node of the last one becomes a
/// subtree that each of its rays traverses on its own (closest_in_subtree.h). Keeps as many more as
/// it takes for a subtree to fit that traversal's stack; 0 keeps all.
void cut_levels(WideBvh& bvh, std::uint32_t queue_levels);

/// By level: its first inner node, as an index into WideBvh::inner, whose nodes are in the order of
/// their ids; last, the end of the last level's.
std::vector<std::uint32_t> inner_begins(const WideBvh& bvh);

/// Hash of structure and boxes: equal on every run and for every thread count.
std::uint64_t fingerprint(const WideBvh& bvh);

/// Every violation found (at most 20), one sentence each naming node and element; empty: valid.
/// Checks: every primitive in exactly one leaf; every child box contains all vertices below it
/// (exactly, no tolerance); node boxes contain their children's; ids, parents, levels, leaf ranges
/// consistent; missing children have the inverted box; every node reachable exactly once.
std::vector<std::string> validate(const WideBvh& bvh, const Scene& scene);

/// Bytes of nodes, leaves and triangles together.
std::size_t memory_bytes(const WideBvh& bvh);

}  // namespace scotty::reference
