/// Conservative ray-box test, monotone in the box.
///
/// Two properties carry the whole suite:
///  - *Conservative*: the box is padded by more than the rounding of this test and of
///    intersect_triangle() together, so no watertight hit is lost at a box's face (after Ize,
///    "Robust BVH Ray Traversal", JCGT 2013, with a spatial pad instead of a scaled far distance).
///  - *Monotone*: rounding preserves order, every step below moves one way when the box grows, and
///    the pad grows with the box. So the entry distance into any enclosing box is never greater,
///    and the exit never smaller, *in floating point, exactly*. intersect_triangle() clamps t into
///    the interval of the triangle's own box; hence every ancestor's box is entered at or before
///    t, and traversal returns exactly the hit of brute force: by construction, not by tolerance.
#pragma once

#include <cmath>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"
#include "reference/contract/records.h"

namespace scotty::reference {

/// Pad per unit of distance, 2^-19 = 32 times half a unit in the last place: 25 for the triangle
/// test and 4 for the slab arithmetic, as cut_changes_nothing() in intersect_triangle.h counts
/// them.
constexpr float kBoxPad = 1.9073486328125e-6f;

/// Reciprocals stay below 2^63, so that a zero direction component needs no special case and
/// products with coordinates up to kMaxCoordinate stay finite: no 0 * infinity, no NaN.
constexpr float kMaxInverse = 9.223372036854775808e18f;

SCOTTY_HD float safe_inverse(float d) {
    const float inverse = 1.0f / d;
    const bool finite = abs_of(inverse) < kMaxInverse;
    return finite ? inverse : (d < 0.0f ? -kMaxInverse : kMaxInverse);
}
SCOTTY_HD Vec3 safe_inverse(const Vec3& d) {
    return {safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z)};
}

SCOTTY_HD Vec3 abs_of(const Vec3& a) { return {abs_of(a.x), abs_of(a.y), abs_of(a.z)}; }

/// How far boxes inside [low, high] are padded for a ray from `origin`.
SCOTTY_HD float box_pad(const Vec3& origin, const Vec3& low, const Vec3& high) {
    const Vec3 reach = max_number(abs_of(low - origin), abs_of(high - origin));
    const Vec3 far = max_number(reach, abs_of(origin));
    return kBoxPad * max_number(max_number(far.x, far.y), far.z);
}

/// A ray prepared for the boxes of one node: plane distance t = fma(plane, inverse, offset).
struct RaySlabs {
    Vec3 inverse;
    Vec3 near_offset;  ///< for the plane where the ray enters: low where inverse > 0, else high
    Vec3 far_offset;
};

SCOTTY_HD float slab_offset(float origin, float inverse, float pad) {
    return -((origin + (inverse > 0.0f ? pad : -pad)) * inverse);
}

SCOTTY_HD RaySlabs ray_slabs(const Vec3& origin, const Vec3& inverse, float pad) {
    return {inverse,
            {slab_offset(origin.x, inverse.x, pad), slab_offset(origin.y, inverse.y, pad),
             slab_offset(origin.z, inverse.z, pad)},
            {slab_offset(origin.x, inverse.x, -pad), slab_offset(origin.y, inverse.y, -pad),
             slab_offset(origin.z, inverse.z, -pad)}};
}

/// Where a ray is inside a (padded) box; entry > exit where it is never.
struct BoxInterval {
    float entry;
    float exit;
};

/// The interval on the whole line, not yet cut to [t_min, t_max).
SCOTTY_HD BoxInterval intersect_box(const RaySlabs& slabs, const Vec3& low, const Vec3& high) {
    const bool px = slabs.inverse.x > 0.0f;
    const bool py = slabs.inverse.y > 0.0f;
    const bool pz = slabs.inverse.z > 0.0f;
    const float near_x = fmaf(px ? low.x : high.x, slabs.inverse.x, slabs.near_offset.x);
    const float near_y = fmaf(py ? low.y : high.y, slabs.inverse.y, slabs.near_offset.y);
    const float near_z = fmaf(pz ? low.z : high.z, slabs.inverse.z, slabs.near_offset.z);
    const float far_x = fmaf(px ? high.x : low.x, slabs.inverse.x, slabs.far_offset.x);
    const float far_y = fmaf(py ? high.y : low.y, slabs.inverse.y, slabs.far_offset.y);
    const float far_z = fmaf(pz ? high.z : low.z, slabs.inverse.z, slabs.far_offset.z);
    return {max_number(max_number(near_x, near_y), near_z),
            min_number(min_number(far_x, far_y), far_z)};
}

/// Cuts to the ray's own interval: overlap where entry <= exit.
SCOTTY_HD BoxInterval clip(const BoxInterval& interval, float t_min, float t_max) {
    return {max_number(interval.entry, t_min), min_number(interval.exit, t_max)};
}

/// True where a ray can have a hit inside: written so that NaN makes it false.
SCOTTY_HD bool overlaps(const BoxInterval& interval) { return interval.entry <= interval.exit; }

}  // namespace scotty::reference
