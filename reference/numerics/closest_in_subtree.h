/// What one ray hits below one node, depth first: how it goes on below the levels that have queues.
///
/// The order is part of the result where any hit will do, since the first leaf with a hit ends the
/// search: children are visited nearest entry first, as far as the entry's bits above the lowest
/// four tell, and then by their place in the node.
#pragma once

#include <cstdint>
#include <cstring>

#include "reference/base/host_device.h"
#include "reference/contract/records.h"
#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"

namespace scotty::reference {

SCOTTY_HD float float_of(std::uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/// A child that is entered, as a number that sorts: where, and which. Missed ones are kNone.
constexpr std::uint32_t kChildBits = 0xfu;
SCOTTY_HD std::uint32_t visit_key(float entry, std::uint32_t child) {
    return (bits_of(entry) & ~kChildBits) | child;
}

/// The `Width` keys of a node's children, nearest first: Batcher's odd-even merge sort, whose
/// comparisons are the same for all keys.
template <int Width>
SCOTTY_HD void sort_visits(std::uint32_t (&keys)[Width]) {
    SCOTTY_UNROLL
    for (int run = 1; run < Width; run *= 2) {
        SCOTTY_UNROLL
        for (int apart = run; apart >= 1; apart /= 2) {
            SCOTTY_UNROLL
            for (int i = 0; i + apart < Width; ++i) {
                const bool compared = i % (2 * apart) >= apart % run &&
                                      (i - apart % run) % (2 * apart) < apart &&
                                      i / (2 * run) == (i + apart) / (2 * run);
                if (!compared) continue;
                const std::uint32_t a = keys[i];
                const std::uint32_t b = keys[i + apart];
                keys[i] = a < b ? a : b;
                keys[i + apart] = a < b ? b : a;
            }
        }
    }
}

/// Offsets that stay finite for a ray from however far away: the planes of a missing child are
/// infinite, and must not meet an infinity of the other sign.
SCOTTY_HD Vec3 saturated(const Vec3& offset) {
    constexpr float kLargest = 3.402823466e38f;
    return max_number(min_number(offset, Vec3(kLargest)), Vec3(-kLargest));
}

/// A ray prepared for all boxes below a node: they are padded as the node's own is, which is more
/// than each needs.
SCOTTY_HD RaySlabs slabs_below(const float (&low)[3], const float (&high)[3], const Ray& ray) {
    const float pad =
        box_pad(ray.origin, Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2]));
    const RaySlabs slabs = ray_slabs(ray.origin, safe_inverse(ray.direction), pad);
    return {slabs.inverse, saturated(slabs.near_offset), saturated(slabs.far_offset)};
}

/// Where a ray enters its first box: never -0, since entries are ordered by their bits.
SCOTTY_HD float first_entry(const Ray& ray) { return ray.t_min + 0.0f; }

/// What a search has found, and what it looked at.
struct SubtreeSearch {
    HitCandidate best{kInfinity, kNone};  ///< the first leaf's with a hit, where any hit will do
    std::uint32_t nodes = 0;              ///< inner nodes whose children's boxes were tested
    std::uint32_t children = 0;           ///< of them, entered
    std::uint32_t triangles = 0;          ///< tested
};

/// Keys of the children whose boxes the ray enters no farther than `limit`.
template <int Width>
SCOTTY_HD void visits_of(const WideNode<Width>& node, const RaySlabs& slabs, float t_min,
                         float limit, std::uint32_t (&keys)[Width]) {
    for (int i = 0; i < Width; ++i) {
        const BoxInterval inside =
            clip(intersect_box(slabs, Vec3(node.low_x[i], node.low_y[i], node.low_z[i]),
                               Vec3(node.high_x[i], node.high_y[i], node.high_z[i])),
                 t_min, limit);
        keys[i] = overlaps(inside) ? visit_key(inside.entry, static_cast<std::uint32_t>(i)) : kNone;
    }
}

/// Lowers `best` to the closest hit in a leaf at or before `limit`.
SCOTTY_HD void closest_in_leaf(const LeafTriangle* triangles, const Leaf& leaf, const Ray& ray,
                               const Vec3& inverse, const RayShear& shear, float limit,
                               HitCandidate& best) {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
        const LeafTriangle& triangle = triangles[i];
        Hit hit = no_hit();
        if (intersect_triangle_line(ray.origin, inverse, shear, triangle.v0, triangle.v1,
                                    triangle.v2, hit) &&
            ray.t_min <= hit.t && hit.t < ray.t_max && hit.t <= limit &&
            closer(hit.t, triangle.primitive, best.t, best.primitive)) {
            best = {hit.t, triangle.primitive};
        }
    }
}

/// The closest hit of a ray below the inner node `root`, or with `any` the closest of the first
/// leaf that has one, at or before `limit`.
template <int Width>
SCOTTY_HD SubtreeSearch closest_in_subtree(const WideBvhView<Width>& bvh, std::uint32_t root,
                                           const Ray& ray, float limit, bool any) {
    struct Waiting {
        float entry;
        std::uint32_t ref;
    };
    Waiting stack[kSubtreeStack + 1];  // a node's children wait for a moment all together
    std::uint32_t waiting = 0;
    const RaySlabs slabs = slabs_below(bvh.inner[root].low, bvh.inner[root].high, ray);
    const RayShear shear = ray_shear(ray.direction);
    SubtreeSearch found;
    stack[waiting++] = {first_entry(ray), root};
    while (waiting > 0) {
        const Waiting next = stack[--waiting];
        if (next.entry > found.best.t) continue;
        if (is_leaf(next.ref)) {
            const Leaf leaf = bvh.leaves[ref_index(next.ref)];
            found.triangles += leaf.count;
            closest_in_leaf(bvh.triangles, leaf, ray, slabs.inverse, shear, limit, found.best);
            if (any && found.best.primitive != kNone) break;
            continue;
        }
        const WideNode<Width>& node = bvh.inner[next.ref];
        std::uint32_t keys[Width];
        visits_of(node, slabs, first_entry(ray),
                  min_number(ray.t_max, min_number(limit, found.best.t)), keys);
        sort_visits(keys);
        found.nodes += 1;
        for (int i = Width - 1; i >= 0; --i) {  // the nearest child is on top
            if (keys[i] == kNone) continue;
            found.children += 1;
            stack[waiting++] = {float_of(keys[i] & ~kChildBits),
                                bvh.node_refs[node.child[keys[i] & kChildBits]]};
        }
    }
    return found;
}

}  // namespace scotty::reference
