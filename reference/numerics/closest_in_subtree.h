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

SCOTTY_HD std::uint32_t bits_of(float value) {
    std::uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}
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

/// One plane of each child's box, on one axis.
template <int Width>
struct alignas(Width == 2 ? 8 : 16) ChildPlanes {
    float at[Width];
};

/// Where a ray enters and leaves the children's boxes. The planes that it enters by are found by
/// address, so that nothing has to be selected for every child.
template <int Width, class Access>
SCOTTY_HD void visits_of(const WideNode<Width>* node, const RaySlabs& slabs, const Ray& ray,
                         float limit, const Access& access, std::uint32_t (&keys)[Width]) {
    using Planes = ChildPlanes<Width>;
    constexpr int kHigh = 3;  // low_x, low_y, low_z, high_x, ...
    const auto* planes = reinterpret_cast<const Planes*>(node->low_x);
    const float last = min_number(ray.t_max, limit);
    float entry[Width];
    float exit[Width];
    SCOTTY_UNROLL
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = axis == 0   ? slabs.inverse.x
                              : axis == 1 ? slabs.inverse.y
                                          : slabs.inverse.z;
        const float near_offset = axis == 0   ? slabs.near_offset.x
                                  : axis == 1 ? slabs.near_offset.y
                                              : slabs.near_offset.z;
        const float far_offset = axis == 0   ? slabs.far_offset.x
                                 : axis == 1 ? slabs.far_offset.y
                                             : slabs.far_offset.z;
        const int high = inverse > 0.0f ? kHigh : 0;
        const Planes near = access.load(planes + axis + kHigh - high);
        const Planes far = access.load(planes + axis + high);
        SCOTTY_UNROLL
        for (int child = 0; child < Width; ++child) {
            const float enters = fmaf(near.at[child], inverse, near_offset);
            const float leaves = fmaf(far.at[child], inverse, far_offset);
            entry[child] = axis == 0 ? enters : max_number(entry[child], enters);
            exit[child] = axis == 0 ? leaves : min_number(exit[child], leaves);
        }
    }
    SCOTTY_UNROLL
    for (int child = 0; child < Width; ++child) {
        const float enters = max_number(entry[child], ray.t_min);
        const bool entered = enters <= min_number(exit[child], last);
        keys[child] = entered ? visit_key(enters, static_cast<std::uint32_t>(child)) : kNone;
    }
}

/// Lowers `best` to the closest hit of one leaf.
template <class Access>
SCOTTY_HD void closest_in_leaf(const LeafTriangle* triangles, const Leaf& leaf, const Ray& ray,
                               const Vec3& inverse, const RayShear& shear, const Access& access,
                               HitCandidate& best) {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
        const LeafTriangle triangle = access.load(triangles + i);
        Hit hit = no_hit();
        if (intersect_triangle_line(ray.origin, inverse, shear, triangle.v0, triangle.v1,
                                    triangle.v2, hit) &&
            ray.t_min <= hit.t && hit.t < ray.t_max &&
            closer(hit.t, triangle.primitive, best.t, best.primitive)) {
            best = {hit.t, triangle.primitive};
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

/// One ray on its way through a subtree: the closest hit below its root, or with `any` the closest
/// of the first leaf that has one, at or before `limit`. Nodes and leaves alternate in runs, so
/// that rays that are traced side by side meet at leaves.
///
/// `access` loads records, and knows what a child of a node is: Record load(const Record*),
/// const WideNode<Width>* node(ref), child_ref(const WideNode<Width>*, child), Leaf leaf(ref),
/// const LeafTriangle* triangles().
template <int Width>
struct SubtreeWalk {
    struct Waiting {
        float entry;
        std::uint32_t ref;
    };

    Ray ray;
    RaySlabs slabs;
    RayShear shear;
    float limit;
    bool any;
    HitCandidate best;  ///< {+infinity, kNone} while there is none
    std::uint32_t ref;  ///< where the ray is, kNone: at its end
    std::uint32_t waiting;
    Waiting stack[kSubtreeStack];

    template <class Access>
    SCOTTY_HD void begin(const Access& access, std::uint32_t root, const Ray& its_ray,
                         float its_limit, bool any_hit) {
        ray = its_ray;
        ray.t_min = first_entry(ray);
        limit = its_limit;
        any = any_hit;
        best = {kInfinity, kNone};
        ref = root;
        waiting = 0;
        if (is_leaf(root)) {
            slabs = {safe_inverse(ray.direction), Vec3(0.0f), Vec3(0.0f)};  // no boxes
        } else {
            slabs = slabs_below(access.node(root)->low, access.node(root)->high, ray);
        }
        shear = ray_shear(ray.direction);
    }

    /// Goes down, nearest child first, until the ray is at a leaf or at its end.
    template <class Access>
    SCOTTY_HD void enter_nodes(const Access& access) {
        while (!is_leaf(ref)) {
            const WideNode<Width>* const node = access.node(ref);
            std::uint32_t keys[Width];
            visits_of<Width>(node, slabs, ray, limit < best.t ? limit : best.t, access, keys);
            sort_visits<Width>(keys);
            SCOTTY_UNROLL
            for (int i = Width - 1; i > 0; --i) {
                if (keys[i] == kNone) continue;
                stack[waiting++] = {float_of(keys[i] & ~kChildBits),
                                    access.child_ref(node, keys[i] & kChildBits)};
            }
            if (keys[0] != kNone) {
                ref = access.child_ref(node, keys[0] & kChildBits);
            } else {
                next();
            }
        }
    }

    /// Until the ray is at an inner node or at its end.
    template <class Access>
    SCOTTY_HD void intersect_leaves(const Access& access) {
        while (is_leaf(ref) && ref != kNone) {
            HitCandidate found = best;
            closest_in_leaf(access.triangles(), access.leaf(ref), ray, slabs.inverse, shear, access,
                            found);
            if (found.t <= limit) best = found;
            if (any && best.primitive != kNone) {
                ref = kNone;
            } else {
                next();
            }
        }
    }

 private:
    SCOTTY_HD void next() {
        do {
            if (waiting == 0) {
                ref = kNone;
                return;
            }
            --waiting;
        } while (stack[waiting].entry > best.t);
        ref = stack[waiting].ref;
    }
};

template <int Width, class Access>
SCOTTY_HD HitCandidate closest_in_subtree(const Access& access, std::uint32_t root, const Ray& ray,
                                          float limit, bool any) {
    SubtreeWalk<Width> walk;
    walk.begin(access, root, ray, limit, any);
    while (walk.ref != kNone) {
        walk.enter_nodes(access);
        walk.intersect_leaves(access);
    }
    return walk.best;
}

}  // namespace scotty::reference
