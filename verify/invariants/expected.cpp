#include "verify/invariants/expected.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <variant>
#include <vector>

#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records, box and triangle tests

NodeBoxes boxes_of(const WideBvh& bvh, std::uint32_t inner_index) {
    NodeBoxes boxes;
    std::visit(
        [&](const auto& nodes) {
            const auto& node = nodes[inner_index];
            boxes.width = static_cast<std::uint32_t>(bvh.width);
            for (std::uint32_t i = 0; i < boxes.width; ++i) {
                boxes.low[i] = Vec3(node.low_x[i], node.low_y[i], node.low_z[i]);
                boxes.high[i] = Vec3(node.high_x[i], node.high_y[i], node.high_z[i]);
                boxes.child[i] = node.child[i];
            }
            boxes.node_low = Vec3(node.low[0], node.low[1], node.low[2]);
            boxes.node_high = Vec3(node.high[0], node.high[1], node.high[2]);
        },
        bvh.inner);
    return boxes;
}

namespace {

ExpectedChildren children_by(const RaySlabs& slabs, const NodeBoxes& node, const Ray& ray,
                             float limit) {
    ExpectedChildren expected;
    for (std::uint32_t c = 0; c < node.width; ++c) {
        if (node.child[c] == kNone) continue;
        const BoxInterval interval =
            clip(intersect_box(slabs, node.low[c], node.high[c]), ray.t_min, ray.t_max);
        if (!overlaps(interval)) continue;
        expected.entry[c] = interval.entry;
        expected.overlapped |= 1u << c;
        if (!(interval.entry > limit)) expected.required |= 1u << c;
    }
    return expected;
}

/// A ray prepared for boxes that are padded as the node's own is.
RaySlabs slabs_of(const NodeBoxes& node, const Ray& ray) {
    return ray_slabs(ray.origin, safe_inverse(ray.direction),
                     box_pad(ray.origin, node.node_low, node.node_high));
}

}  // namespace

ExpectedChildren expected_children(const NodeBoxes& node, const Ray& ray, float limit) {
    return children_by(slabs_of(node, ray), node, ray, limit);
}

ExpectedChildren expected_pairs(const NodeBoxes& node, const NodeBoxes& root, const Ray& ray,
                                float limit) {
    return children_by(slabs_of(root, ray), node, ray, limit);
}

HitCandidate closest_in_leaf(const WideBvh& bvh, const Leaf& leaf, const Ray& ray) {
    HitCandidate best{kInfinity, kNone};
    const Vec3 inverse = safe_inverse(ray.direction);
    const RayShear shear = ray_shear(ray.direction);
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
        const LeafTriangle& triangle = bvh.triangles[i];
        Hit hit = no_hit();
        if (intersect_triangle(ray, inverse, shear, triangle.v0, triangle.v1, triangle.v2, hit) &&
            closer(hit.t, triangle.primitive, best.t, best.primitive)) {
            best = {hit.t, triangle.primitive};
        }
    }
    return best;
}

namespace {

HitCandidate hit_below(const WideBvh& bvh, std::uint32_t inner_index, const Ray& ray,
                       const RaySlabs& slabs, bool any) {
    const NodeBoxes boxes = boxes_of(bvh, inner_index);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> order;  // of entry, child
    for (std::uint32_t c = 0; c < boxes.width; ++c) {
        if (boxes.child[c] == kNone) continue;
        const BoxInterval interval =
            clip(intersect_box(slabs, boxes.low[c], boxes.high[c]), ray.t_min, ray.t_max);
        if (overlaps(interval)) {
            order.emplace_back(std::bit_cast<std::uint32_t>(interval.entry) / 16, c);
        }
    }
    std::sort(order.begin(), order.end());
    HitCandidate best{kInfinity, kNone};
    for (const auto& [entry, c] : order) {
        const std::uint32_t ref = bvh.node_refs[boxes.child[c]];
        const HitCandidate hit = is_leaf(ref)
                                     ? closest_in_leaf(bvh, bvh.leaves[ref_index(ref)], ray)
                                     : hit_below(bvh, ref_index(ref), ray, slabs, any);
        if (closer(hit.t, hit.primitive, best.t, best.primitive)) best = hit;
        if (any && best.primitive != kNone) break;
    }
    return best;
}

}  // namespace

HitCandidate hit_of_subtree(const WideBvh& bvh, std::uint32_t inner_index, const Ray& ray,
                            bool any) {
    return hit_below(bvh, inner_index, ray, slabs_of(boxes_of(bvh, inner_index), ray), any);
}

}  // namespace scotty::verify
