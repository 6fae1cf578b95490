/// The pool of a warp: visits of its rays to nodes and leaves of a subtree, taken 32 at a time by
/// whichever lanes there are.
///
/// Rays that go through a subtree each for itself leave most lanes of a warp idle: one is at a
/// leaf, another has ended. A pooled visit is any lane's. What a visit does is what
/// reference/closest_in_subtree.h does; only the order is another, and the closest hit does not
/// depend on it.
#pragma once

#include "gpu/dialect.h"
#include "gpu/subtree_access.h"
#include "gpu/views.h"
#include "reference/closest_in_subtree.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kPoolRays = kWarpSize;
/// A visit's entry gives up its lowest bits to the place of its ray.
constexpr std::uint32_t kPlaceBits = kPoolRays - 1;

struct alignas(16) Quad {
    float x, y, z, w;
};

struct alignas(8) Visit {
    std::uint32_t ref;
    std::uint32_t entry_and_place;

    SCOTTY_HD float entry() const { return reference::float_of(entry_and_place & ~kPlaceBits); }
    SCOTTY_HD std::uint32_t place() const { return entry_and_place & kPlaceBits; }
};
SCOTTY_HD Visit visit_of(std::uint32_t ref, std::uint32_t entry_bits, std::uint32_t place) {
    return {ref, (entry_bits & ~kPlaceBits) | place};
}

SCOTTY_DEVICE std::uint64_t packed_hit(const reference::HitCandidate& hit) {
    return static_cast<std::uint64_t>(float_bits(hit.t)) << 32 | hit.primitive;
}
SCOTTY_DEVICE reference::HitCandidate unpacked_hit(std::uint64_t packed) {
    return {bits_float(static_cast<std::uint32_t>(packed >> 32)),
            static_cast<std::uint32_t>(packed)};
}

/// Shared memory of one warp. Rays are by place, 16 bytes apart, so that lanes of different rays
/// read from different banks.
template <int Width>
struct SubtreePool {
    /// All lanes push all children of their nodes; what is above is for one visit alone, to the
    /// bottom of any subtree.
    static constexpr std::uint32_t kSharedNodes = kPoolRays + kWarpSize * (Width - 1);
    static constexpr std::uint32_t kNodes = kSharedNodes + reference::kSubtreeStack;
    /// Leaves are visited as soon as there are as many as lanes.
    static constexpr std::uint32_t kLeaves = kWarpSize * (Width + 1);

    Quad inverse[kPoolRays];      ///< and t_min
    Quad near_offset[kPoolRays];  ///< and t_max
    Quad far_offset[kPoolRays];
    Quad origin[kPoolRays];  ///< and the bits of kz
    Quad shear[kPoolRays];
    std::uint64_t best[kPoolRays];  ///< t and primitive: at first the ray's limit, and none
    std::uint32_t ray_id[kPoolRays];
    Visit nodes[kNodes];
    Visit leaves[kLeaves];

    SCOTTY_HD reference::Vec3 origin_of(std::uint32_t place) const {
        return reference::Vec3(origin[place].x, origin[place].y, origin[place].z);
    }
    SCOTTY_HD reference::RayShear shear_of(std::uint32_t place) const {
        return {static_cast<int>(reference::bits_of(origin[place].w)), shear[place].x,
                shear[place].y, shear[place].z};
    }
    SCOTTY_HD reference::Vec3 inverse_of(std::uint32_t place) const {
        return reference::Vec3(inverse[place].x, inverse[place].y, inverse[place].z);
    }
};

template <int Width>
SCOTTY_DEVICE void put_ray(SubtreePool<Width>& pool, std::uint32_t place, std::uint32_t ray_id,
                           const reference::Ray& ray, const reference::RaySlabs& slabs,
                           float limit) {
    const reference::Vec3& near = slabs.near_offset;
    const reference::Vec3& far = slabs.far_offset;
    const reference::RayShear shear = reference::ray_shear(ray.direction);
    pool.inverse[place] = {slabs.inverse.x, slabs.inverse.y, slabs.inverse.z,
                           reference::first_entry(ray)};
    pool.near_offset[place] = {near.x, near.y, near.z, ray.t_max};
    pool.far_offset[place] = {far.x, far.y, far.z, 0.0f};
    pool.origin[place] = {ray.origin.x, ray.origin.y, ray.origin.z,
                          bits_float(static_cast<std::uint32_t>(shear.kz))};
    pool.shear[place] = {shear.sx, shear.sy, shear.sz, 0.0f};
    pool.best[place] = packed_hit({limit, reference::kNone});
    pool.ray_id[place] = ray_id;
}

/// Lowers the best hit of a leaf's ray.
template <int Width>
SCOTTY_DEVICE void visit_leaf(SubtreePool<Width>& pool, const SubtreeAccess<Width>& access,
                              const Visit& visit) {
    const std::uint32_t place = visit.place();
    const std::uint64_t before = load_relaxed(&pool.best[place]);  // others may lower it
    reference::HitCandidate best = unpacked_hit(before);
    if (!(visit.entry() <= best.t)) return;
    const reference::Ray ray{pool.origin_of(place), pool.inverse[place].w, reference::Vec3(0.0f),
                             pool.near_offset[place].w};
    reference::closest_in_leaf(access.triangles(), access.leaf(visit.ref), ray,
                               pool.inverse_of(place), pool.shear_of(place), access, best);
    const std::uint64_t after = packed_hit(best);
    if (after < before) atomic_min(&pool.best[place], after);
}

/// Children that a visit found, nearest first; kNone: no more.
template <int Width>
struct ChildVisits {
    std::uint32_t keys[Width];
    std::uint32_t refs[Width];
};

template <int Width>
SCOTTY_DEVICE void visit_node(const SubtreePool<Width>& pool, const SubtreeAccess<Width>& access,
                              const Visit& visit, ChildVisits<Width>& found) {
    const std::uint32_t place = visit.place();
    const float limit = unpacked_hit(pool.best[place]).t;
    if (!(visit.entry() <= limit)) return;
    const Quad near = pool.near_offset[place];
    const Quad far = pool.far_offset[place];
    const reference::RaySlabs slabs{
        pool.inverse_of(place), {near.x, near.y, near.z}, {far.x, far.y, far.z}};
    const reference::Ray ray{reference::Vec3(0.0f), pool.inverse[place].w, reference::Vec3(0.0f),
                             near.w};
    const reference::WideNode<Width>* const node = access.node(visit.ref);
    reference::visits_of<Width>(node, slabs, ray, limit, access, found.keys);
    reference::sort_visits<Width>(found.keys);
    SCOTTY_UNROLL
    for (int rank = 0; rank < Width; ++rank) {
        if (found.keys[rank] == reference::kNone) continue;
        found.refs[rank] = access.child_ref(node, found.keys[rank] & reference::kChildBits);
    }
}

/// Visits that wait.
struct PoolCounts {
    std::uint32_t nodes;
    std::uint32_t leaves;
};

/// The farthest children of all lanes first, so that the nearest ones are on top.
template <int Width>
SCOTTY_COLLECTIVE(PoolCounts)
push_visits(SubtreePool<Width>& pool, PoolCounts counts, const ChildVisits<Width>& found,
            std::uint32_t place) {
    SCOTTY_UNROLL
    for (int rank = Width - 1; rank >= 0; --rank) {
        const bool there = found.keys[rank] != reference::kNone;
        const std::uint32_t lanes = SCOTTY_AWAIT(warp_ballot(there));
        if (lanes == 0) continue;
        const bool leaf = there && reference::is_leaf(found.refs[rank]);
        const std::uint32_t at_leaf = SCOTTY_AWAIT(warp_ballot(leaf));
        const std::uint32_t at_node = lanes & ~at_leaf;
        if (there) {
            Visit& slot = leaf ? pool.leaves[counts.leaves + count_bits(bits_below_lane(at_leaf))]
                               : pool.nodes[counts.nodes + count_bits(bits_below_lane(at_node))];
            slot = visit_of(found.refs[rank], found.keys[rank], place);
        }
        counts.nodes += count_bits(at_node);
        counts.leaves += count_bits(at_leaf);
    }
    SCOTTY_RETURN counts;
}

/// Until no visit waits. Leaves first, where there are enough for all lanes.
template <int Width>
SCOTTY_COLLECTIVE(void)
empty_pool(SubtreePool<Width>& pool, const SubtreeAccess<Width>& access, PoolCounts counts) {
    while (counts.nodes + counts.leaves != 0) {
        if (counts.leaves >= kWarpSize || counts.nodes == 0) {
            const std::uint32_t taken = counts.leaves < kWarpSize ? counts.leaves : kWarpSize;
            counts.leaves -= taken;
            if (lane_index() < taken) {
                visit_leaf(pool, access, pool.leaves[counts.leaves + lane_index()]);
            }
            SCOTTY_SYNC();
            continue;
        }
        // No more than there is room for what they push; for one there always is.
        constexpr std::uint32_t kShared = SubtreePool<Width>::kSharedNodes;
        const std::uint32_t room =
            counts.nodes < kShared ? (kShared - counts.nodes) / (Width - 1) : 0;
        std::uint32_t taken = counts.nodes < kWarpSize ? counts.nodes : kWarpSize;
        if (taken > room) taken = room > 1 ? room : 1;
        counts.nodes -= taken;
        ChildVisits<Width> found;
        SCOTTY_UNROLL
        for (int rank = 0; rank < Width; ++rank) found.keys[rank] = reference::kNone;
        std::uint32_t place = 0;
        if (lane_index() < taken) {
            const Visit visit = pool.nodes[counts.nodes + lane_index()];
            place = visit.place();
            visit_node(pool, access, visit, found);
        }
        SCOTTY_SYNC();
        counts = SCOTTY_AWAIT(push_visits(pool, counts, found, place));
        SCOTTY_SYNC();
    }
    SCOTTY_RETURN;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
