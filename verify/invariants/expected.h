/// What one ray does in one node, by a straight loop over children or triangles with the tests of
/// reference/. check_*.cpp compare queues and hits with it, and queues_history.h explains them by
/// it.
#pragma once

#include <array>
#include <cstdint>

#include "reference/contract/records.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::verify {

inline constexpr std::uint32_t kMaxWidth = 16;

/// A wide node of any width.
struct NodeBoxes {
    std::uint32_t width = 0;
    std::array<reference::Vec3, kMaxWidth> low, high;
    std::array<std::uint32_t, kMaxWidth> child{};  ///< node ids, kNone for unused slots
    reference::Vec3 node_low, node_high;
};
NodeBoxes boxes_of(const reference::WideBvh& bvh, std::uint32_t inner_index);

/// The outcome of one ray in one inner node. Bit c is child c.
struct ExpectedChildren {
    std::uint32_t overlapped = 0;
    std::uint32_t required = 0;  ///< those overlapped ones that are not farther than the limit
    std::array<float, kMaxWidth> entry{};  ///< where it enters the overlapped ones
};
/// `limit` is the nearest hit known, +infinity if nothing culls.
ExpectedChildren expected_children(const NodeBoxes& node, const reference::Ray& ray, float limit);

/// The same with boxes padded as `root` is: a level with a queue of pairs.
ExpectedChildren expected_pairs(const NodeBoxes& node, const NodeBoxes& root,
                                const reference::Ray& ray, float limit);

/// Closest hit of one ray in one leaf; {+infinity, kNone} if there is none.
reference::HitCandidate closest_in_leaf(const reference::WideBvh& bvh, const reference::Leaf& leaf,
                                        const reference::Ray& ray);

/// The hit of a ray below an inner node of the last level that has queues: its closest hit, or with
/// `any` the closest of the first leaf that has one, in the order of
/// reference/numerics/closest_in_subtree.h. Every box that the ray overlaps is entered: known hits
/// cull nothing.
reference::HitCandidate hit_of_subtree(const reference::WideBvh& bvh, std::uint32_t inner_index,
                                       const reference::Ray& ray, bool any);

}  // namespace scotty::verify
