/// A ray on its way through a subtree, alone and depth-first.
///
/// closest_in_subtree() in reference/numerics/closest_in_subtree.h defines what it does, in which
/// order and with which bits; how it does so is the device's matter. Comparisons, selections and
/// integer sums share a pipe with half the rate of multiply-adds, and make up most of an ordinary
/// walk. So planes are selected by address, minima and maxima take three values at once, and a
/// waiting child is its sort key and its parent, and is looked up when its turn comes.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/subtree_nodes.h"
#include "gpu/kernels/views.h"
#include "reference/numerics/closest_in_subtree.h"
#include "reference/numerics/intersect_triangle.h"

namespace SCOTTY_DEVICE_NAMESPACE {

template <int Width>
struct SubtreeRay {
    /// Planes are loaded in pieces of this many children.
    static constexpr int kGroup = Width < 4 ? Width : 4;
    using Planes = ChildPlanes<kGroup>;

    reference::RaySlabs slabs;
    const Planes* near_x;  ///< of node 0: the planes that the ray enters by
    const Planes* near_y;
    const Planes* near_z;
    reference::Vec3 origin;  ///< axes swapped, as for the shear
    reference::RayShear shear;
    float t_min;
    float best_t;                  ///< what culls: the best hit, or how far the ray goes
    std::uint32_t best_primitive;  ///< at equal t lower ones win; without a hit, all or none do
    /// Of the best hit, 0 if there is none; its barycentrics are these edges over it.
    float determinant;
    float edge_v, edge_w;
    std::uint32_t at;       ///< where the ray is; kNone: at its end
    std::uint32_t waiting;  ///< entries of the ray's SubtreeStack
};

template <int Width>
SCOTTY_DEVICE bool has_hit(const SubtreeRay<Width>& walk) {
    return walk.determinant != 0.0f;
}

/// The divisions are left until the hit is final.
template <int Width>
SCOTTY_DEVICE reference::Hit best_hit(const SubtreeRay<Width>& walk) {
    if (!has_hit(walk)) return reference::no_hit();
    return {walk.best_t, walk.best_primitive, walk.edge_v / walk.determinant,
            walk.edge_w / walk.determinant};
}

/// Children that wait. They are not in SubtreeRay, because an array that is indexed at run time
/// keeps its whole object in memory.
struct SubtreeStack {
    struct Child {
        std::uint32_t key;  ///< reference::visit_key()
        std::uint32_t parent;
    };
    Child children[reference::kSubtreeStack];
};

template <int Width>
SCOTTY_DEVICE const typename SubtreeRay<Width>::Planes* planes_entered(const BvhView<Width>& bvh,
                                                                       int axis, float inverse) {
    const auto* low =
        reinterpret_cast<const typename SubtreeRay<Width>::Planes*>(&bvh.subtrees->planes[axis][0]);
    return inverse > 0.0f ? low : low + Width / SubtreeRay<Width>::kGroup;
}

/// A ray's start: a node of the last level that has queues.
struct SubtreeRoot {
    std::uint32_t at;       ///< as SubtreeRay::at
    float low[3], high[3];  ///< its box; for a leaf it is not used
};

/// `ref` is the node's entry in node_refs.
template <int Width>
SCOTTY_DEVICE SubtreeRoot subtree_root(const BvhView<Width>& bvh, std::uint32_t ref) {
    if (reference::is_leaf(ref)) {
        return {reference::kLeafBit | bvh.leaves[reference::ref_index(ref)].first, {}, {}};
    }
    const reference::WideNode<Width>& node = bvh.inner[ref];
    return {ref - bvh.first_subtree,
            {node.low[0], node.low[1], node.low[2]},
            {node.high[0], node.high[1], node.high[2]}};
}

template <int Width>
SCOTTY_DEVICE void begin_subtree(SubtreeRay<Width>& walk, const BvhView<Width>& bvh,
                                 const SubtreeRoot& root, const reference::Ray& ray, float limit) {
    walk.slabs = reference::slabs_below(root.low, root.high, ray);
    walk.near_x = planes_entered(bvh, 0, walk.slabs.inverse.x);
    walk.near_y = planes_entered(bvh, 1, walk.slabs.inverse.y);
    walk.near_z = planes_entered(bvh, 2, walk.slabs.inverse.z);
    walk.shear = reference::ray_shear(ray.direction);
    walk.origin = reference::swap_axes(ray.origin, walk.shear.kz);
    walk.t_min = reference::first_entry(ray);
    // A hit at the limit counts, one at t_max does not.
    walk.best_t = limit < ray.t_max ? limit : ray.t_max;
    walk.best_primitive = limit < ray.t_max ? reference::kNone : 0;
    walk.determinant = 0.0f;
    walk.edge_v = 0.0f;
    walk.edge_w = 0.0f;
    walk.waiting = 0;
    walk.at = reference::is_dead(ray) ? reference::kNone : root.at;
}

/// The planes on the other side of the same boxes.
template <int Width, class Planes>
SCOTTY_DEVICE const Planes* other_side(const Planes* planes) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): nodes are aligned so that one bit is the side
    return reinterpret_cast<const Planes*>(reinterpret_cast<std::uintptr_t>(planes) ^
                                           (Width * sizeof(float)));
}

/// Keys of the children that a ray enters, as reference::visits_of() returns them.
///
/// Compared by bits as integers, the three entries' maximum is wrong only if all are negative,
/// which t_min, never less than +0, fixes; the exits' minimum only if one is negative, but then it
/// is negative too (or -0, which lets the ray into a box behind it that has no hit).
template <int Width>
SCOTTY_DEVICE void children_of(const SubtreeRay<Width>& walk, std::uint32_t (&keys)[Width]) {
    using Planes = typename SubtreeRay<Width>::Planes;
    constexpr int kGroup = SubtreeRay<Width>::kGroup;
    constexpr std::uint32_t kStride = kPlanesInNode * Width / kGroup;
    const reference::RaySlabs& slabs = walk.slabs;
    const Planes* const near_x = walk.near_x + static_cast<std::size_t>(walk.at) * kStride;
    const Planes* const near_y = walk.near_y + static_cast<std::size_t>(walk.at) * kStride;
    const Planes* const near_z = walk.near_z + static_cast<std::size_t>(walk.at) * kStride;
    SCOTTY_UNROLL
    for (int group = 0; group < Width / kGroup; ++group) {
        const Planes enter_x = load_record(near_x + group);
        const Planes enter_y = load_record(near_y + group);
        const Planes enter_z = load_record(near_z + group);
        const Planes leave_x = load_record(other_side<Width>(near_x) + group);
        const Planes leave_y = load_record(other_side<Width>(near_y) + group);
        const Planes leave_z = load_record(other_side<Width>(near_z) + group);
        SCOTTY_UNROLL
        for (int i = 0; i < kGroup; ++i) {
            const float enters = greatest_bits(
                greatest_bits(fmaf(enter_x.at[i], slabs.inverse.x, slabs.near_offset.x),
                              fmaf(enter_y.at[i], slabs.inverse.y, slabs.near_offset.y),
                              fmaf(enter_z.at[i], slabs.inverse.z, slabs.near_offset.z)),
                walk.t_min);
            const float leaves =
                least_bits(least_bits(fmaf(leave_x.at[i], slabs.inverse.x, slabs.far_offset.x),
                                      fmaf(leave_y.at[i], slabs.inverse.y, slabs.far_offset.y),
                                      fmaf(leave_z.at[i], slabs.inverse.z, slabs.far_offset.z)),
                           walk.best_t);
            const auto child = static_cast<std::uint32_t>(group * kGroup + i);
            keys[child] = enters <= leaves ? reference::visit_key(enters, child) : reference::kNone;
        }
    }
}

template <int Width>
SCOTTY_DEVICE std::uint32_t child_ref(const BvhView<Width>& bvh, std::uint32_t parent,
                                      std::uint32_t key) {
    return load_record(&bvh.subtrees[parent].child[key & reference::kChildBits]);
}

/// Goes on to the nearest waiting child that is not too far by now.
template <int Width>
SCOTTY_DEVICE void next_visit(SubtreeRay<Width>& walk, const SubtreeStack& stack,
                              const BvhView<Width>& bvh) {
    walk.at = reference::kNone;
    while (walk.waiting != 0) {
        const SubtreeStack::Child top = stack.children[--walk.waiting];
        if (bits_float(top.key & ~reference::kChildBits) > walk.best_t) continue;
        walk.at = child_ref(bvh, top.parent, top.key);
        break;
    }
}

/// Goes down, nearest child first, until the ray is at a leaf or at its end.
template <int Width>
SCOTTY_DEVICE void enter_nodes(SubtreeRay<Width>& walk, SubtreeStack& stack,
                               const BvhView<Width>& bvh) {
    while (!reference::is_leaf(walk.at)) {
        const std::uint32_t here = walk.at;
        std::uint32_t keys[Width];
        children_of(walk, keys);
        reference::sort_visits<Width>(keys);
        SCOTTY_UNROLL
        for (int i = Width - 1; i > 0; --i) {
            if (keys[i] != reference::kNone) stack.children[walk.waiting++] = {keys[i], here};
        }
        if (keys[0] != reference::kNone) {
            walk.at = child_ref(bvh, here, keys[0]);
        } else {
            next_visit(walk, stack, bvh);
        }
    }
}

/// Lowers the best hit by the triangle whose rows begin at `first`; returns whether that is the
/// last of its leaf.
template <int Width>
SCOTTY_DEVICE bool visit_triangle(SubtreeRay<Width>& walk, const TriangleRow* rows,
                                  std::uint32_t first) {
    using reference::Vec3;
    const auto kz = static_cast<std::uint32_t>(walk.shear.kz);
    const TriangleRow x = load_record(rows + (first + (kz == 0 ? 2u : 0u)));
    const TriangleRow y = load_record(rows + (first + (kz == 1 ? 2u : 1u)));
    const TriangleRow z = load_record(rows + (first + kz));
    const bool last = (x.primitive_and_last & kLastBit) != 0;
    const Vec3 v0(x.v0, y.v0, z.v0);
    const Vec3 v1(x.v1, y.v1, z.v1);
    const Vec3 v2(x.v2, y.v2, z.v2);
    const Vec3 a = v0 - walk.origin;
    const Vec3 b = v1 - walk.origin;
    const Vec3 c = v2 - walk.origin;
    const reference::ShearedTriangle sheared = reference::shear(walk.shear, a, b, c);
    reference::EdgeFunctions edges;
    if (!reference::signed_edges(sheared, edges)) return last;
    const reference::Crossing crossing = reference::crossing_of(walk.shear, edges, a, b, c);
    if (!(reference::abs_of(crossing.determinant) > 0.0f)) return last;
    reference::CutDistance cut{crossing.t, true};
    if (!reference::cut_changes_nothing(crossing, sheared, walk.origin, a.z)) {
        cut = reference::cut_distance(crossing.t, walk.origin,
                                      reference::swap_axes(walk.slabs.inverse, walk.shear.kz),
                                      reference::min_number(reference::min_number(v0, v1), v2),
                                      reference::max_number(reference::max_number(v0, v1), v2));
    }
    const std::uint32_t primitive = x.primitive_and_last & ~kLastBit;
    if (cut.inside && walk.t_min <= cut.t &&
        reference::closer(cut.t, primitive, walk.best_t, walk.best_primitive)) {
        walk.best_t = cut.t;
        walk.best_primitive = primitive;
        walk.determinant = crossing.determinant;
        walk.edge_v = crossing.edges.v;
        walk.edge_w = crossing.edges.w;
    }
    return last;
}

/// Runs until the ray is at an inner node or at its end; with `Any` its first hit ends it.
template <bool Any, int Width>
SCOTTY_DEVICE void intersect_leaves(SubtreeRay<Width>& walk, const SubtreeStack& stack,
                                    const BvhView<Width>& bvh) {
    while (reference::is_leaf(walk.at) && walk.at != reference::kNone) {
        std::uint32_t first = 3 * reference::ref_index(walk.at);
        while (!visit_triangle(walk, bvh.triangles->axis, first)) first += 3;
        if (Any && has_hit(walk)) {
            walk.at = reference::kNone;
        } else {
            next_visit(walk, stack, bvh);
        }
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
