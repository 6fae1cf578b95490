/// Watertight ray-triangle test: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection",
/// JCGT 2(1), 2013; two-sided, with the paper's double-precision fallback on edges.
///
/// One addition: t is clamped into the ray's interval through the triangle's own padded box. Away
/// from degenerate cases that changes nothing; for a sliver seen edge-on, whose barycentrics are
/// rounding noise, it keeps t where the ray meets the box, which is what makes traversal equal to
/// brute force exactly (see intersect_box.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/numerics/intersect_box.h"

namespace scotty::reference {

SCOTTY_HD std::uint32_t bits_of(float value) {
    std::uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

SCOTTY_HD float component(const Vec3& v, int axis) {
    return axis == 0 ? v.x : (axis == 1 ? v.y : v.z);
}
SCOTTY_HD int next_axis(int axis) { return axis == 2 ? 0 : axis + 1; }

/// A vector with axis `kz` and the last one swapped: four selects, no branch, so that loops over
/// rays vectorise. It turns triangles over, which is nothing to a two-sided test.
SCOTTY_HD Vec3 swap_axes(const Vec3& v, int kz) {
    const bool x_last = kz == 0;
    const bool y_last = kz == 1;
    return {x_last ? v.z : v.x, y_last ? v.z : v.y, x_last ? v.x : (y_last ? v.y : v.z)};
}

/// The shear that maps a ray to the unit ray along z; computed once per ray.
struct RayShear {
    int kz;  ///< the axis along which the direction is largest
    float sx, sy, sz;
};

SCOTTY_HD RayShear ray_shear(const Vec3& direction) {
    const float ax = abs_of(direction.x);
    const float ay = abs_of(direction.y);
    const float az = abs_of(direction.z);
    const int kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    const Vec3 d = swap_axes(direction, kz);
    return {kz, d.x / d.z, d.y / d.z, 1.0f / d.z};
}

/// Signed areas opposite v0, v1, v2, after the shear.
struct EdgeFunctions {
    float u, v, w;
};

/// True where the signs differ, that is: the ray passes outside. A zero has no sign. NaN counts as
/// outside elsewhere (the determinant test), not here.
SCOTTY_HD bool outside(const EdgeFunctions& e) {
    return (e.u < 0.0f || e.v < 0.0f || e.w < 0.0f) && (e.u > 0.0f || e.v > 0.0f || e.w > 0.0f);
}

/// True where one may be zero or NaN: the product is not above 0 where it vanishes, underflows, or
/// is 0 times infinity. One comparison for three, which have half the rate of products on a device.
SCOTTY_HD bool may_be_zero(const EdgeFunctions& e) { return !(abs_of(e.u * e.v * e.w) > 0.0f); }

/// outside() by the bits of the signs. Requires !may_be_zero(e).
SCOTTY_HD bool signs_differ(const EdgeFunctions& e) {
    const std::uint32_t u = bits_of(e.u);
    return (((u ^ bits_of(e.v)) | (u ^ bits_of(e.w))) >> 31) != 0;
}

/// The sheared x and y of three vertices.
struct ShearedTriangle {
    float ax, ay, bx, by, cx, cy;
};

SCOTTY_HD EdgeFunctions edge_functions(const ShearedTriangle& s) {
    return {s.cx * s.by - s.cy * s.bx, s.ax * s.cy - s.ay * s.cx, s.bx * s.ay - s.by * s.ax};
}

/// The same in double: products of floats are exact there, so the signs are.
SCOTTY_HD EdgeFunctions edge_functions_exact_sign(const ShearedTriangle& s) {
    const double ax = s.ax, ay = s.ay, bx = s.bx, by = s.by, cx = s.cx, cy = s.cy;
    return {static_cast<float>(cx * by - cy * bx), static_cast<float>(ax * cy - ay * cx),
            static_cast<float>(bx * ay - by * ax)};
}

/// Edge functions whose signs are those of exact arithmetic. Returns false where the line passes
/// outside. A difference of rounded products that is not zero has the exact sign, because rounding
/// preserves order; where one is zero, double precision decides.
SCOTTY_HD bool signed_edges(const ShearedTriangle& sheared, EdgeFunctions& e) {
    e = edge_functions(sheared);
    if (!may_be_zero(e)) return !signs_differ(e);
    if (outside(e)) return false;
    if (e.u != 0.0f && e.v != 0.0f && e.w != 0.0f) return true;
    e = edge_functions_exact_sign(sheared);
    return !outside(e);
}

/// `a`, `b`, `c`: vertices relative to the ray's origin, axes swapped.
SCOTTY_HD ShearedTriangle shear(const RayShear& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
    return {a.x - ray.sx * a.z, a.y - ray.sy * a.z, b.x - ray.sx * b.z,
            b.y - ray.sy * b.z, c.x - ray.sx * c.z, c.y - ray.sy * c.z};
}

/// A line that passes through a triangle, before its t is known to be in the triangle's box.
struct Crossing {
    EdgeFunctions edges;
    float determinant;
    float t;  ///< NaN where it cannot be told
};

/// The crossing of a line with these edge functions; `a`, `b`, `c` as below.
SCOTTY_HD Crossing crossing_of(const RayShear& ray, const EdgeFunctions& e, const Vec3& a,
                               const Vec3& b, const Vec3& c) {
    const float determinant = e.u + e.v + e.w;
    const float scaled_t = e.u * (ray.sz * a.z) + e.v * (ray.sz * b.z) + e.w * (ray.sz * c.z);
    return {e, determinant, scaled_t / determinant};
}

/// Where the line crosses the triangle `a`, `b`, `c`: vertices relative to the ray's origin, axes
/// swapped. Returns false where it passes outside.
SCOTTY_HD bool crosses(const RayShear& ray, const Vec3& a, const Vec3& b, const Vec3& c,
                       Crossing& crossing) {
    EdgeFunctions e;
    if (!signed_edges(shear(ray, a, b, c), e)) return false;
    crossing = crossing_of(ray, e, a, b, c);
    return abs_of(crossing.determinant) > 0.0f;
}

/// A distance cut to the ray's interval through a box; `inside` is false where there is none.
struct CutDistance {
    float t;
    bool inside;
};

/// A crossing's distance, cut to the ray's interval through the padded box [low, high].
SCOTTY_HD CutDistance cut_distance(float t, const Vec3& origin, const Vec3& inverse,
                                   const Vec3& low, const Vec3& high) {
    const BoxInterval box =
        intersect_box(ray_slabs(origin, inverse, box_pad(origin, low, high)), low, high);
    // A quotient that is NaN becomes the entry.
    const float cut = min_number(max_number(t, box.entry), box.exit);
    const bool inside =
        static_cast<bool>(static_cast<int>(box.entry <= cut) & static_cast<int>(cut <= box.exit));
    return {cut + 0.0f, inside};  // -0 becomes +0: distances are ordered by their bits
}

/// True only where cut_distance() would return crossing.t as it is: almost always, and then box and
/// cut need not be computed. `origin` and the depth of the triangle's first corner (its last
/// coordinate relative to the origin) are as for crosses(); the edges have the signs that it found.
/// docs/design.md has the proof.
SCOTTY_HD bool cut_changes_nothing(const Crossing& crossing, const ShearedTriangle& s,
                                   const Vec3& origin, float depth) {
    const float products = abs_of(s.cx * s.by) + abs_of(s.cy * s.bx) + abs_of(s.ax * s.cy) +
                           abs_of(s.ay * s.cx) + abs_of(s.bx * s.ay) + abs_of(s.by * s.ax);
    const float size = max_number(
        max_number(max_number(abs_of(s.ax), abs_of(s.ay)), max_number(abs_of(s.bx), abs_of(s.by))),
        max_number(abs_of(s.cx), abs_of(s.cy)));
    const float reach = max_number(max_number(abs_of(origin.x), abs_of(origin.y)),
                                   max_number(abs_of(origin.z), abs_of(depth)));
    const float determinant = abs_of(crossing.determinant);
    constexpr float kLeastDeterminant = 8.2718061255302767e-25f;  // 2^-80
    constexpr float kLeastT = 9.31322574615478515625e-10f;        // 2^-30
    constexpr float kMostT = 1073741824.0f;                       // 2^30, of the reach
    constexpr float kMostReach = 1152921504606846976.0f;          // 2^60
    return determinant * reach >= 0.125f * products * size && determinant >= kLeastDeterminant &&
           crossing.t >= kLeastT && crossing.t <= kMostT * reach && reach <= kMostReach;
}

/// The hit of a crossing, its t cut to the ray's interval through the triangle's own padded box,
/// which lies in [low, high]; axes swapped for all arguments or for none. Returns false, and leaves
/// `hit` alone, where the ray misses the box.
SCOTTY_HD bool cut_to_box(const Crossing& crossing, const Vec3& origin, const Vec3& inverse,
                          const Vec3& low, const Vec3& high, Hit& hit) {
    const CutDistance cut = cut_distance(crossing.t, origin, inverse, low, high);
    if (!cut.inside) return false;
    hit.t = cut.t;
    hit.u = crossing.edges.v / crossing.determinant;
    hit.v = crossing.edges.w / crossing.determinant;
    return true;
}

/// Hit of the whole line with the triangle, t not yet compared with the ray's interval.
/// Returns false on a miss and leaves `hit` alone; the primitive id is the caller's.
SCOTTY_HD bool intersect_triangle_line(const Vec3& origin, const Vec3& inverse, const RayShear& ray,
                                       const Vec3& v0, const Vec3& v1, const Vec3& v2, Hit& hit) {
    Crossing crossing;
    if (!crosses(ray, swap_axes(v0 - origin, ray.kz), swap_axes(v1 - origin, ray.kz),
                 swap_axes(v2 - origin, ray.kz), crossing)) {
        return false;
    }
    return cut_to_box(crossing, origin, inverse, min_number(min_number(v0, v1), v2),
                      max_number(max_number(v0, v1), v2), hit);
}

/// The whole test for one ray and one triangle: a hit with t in [t_min, t_max).
SCOTTY_HD bool intersect_triangle(const Ray& ray, const Vec3& inverse, const RayShear& shear,
                                  const Vec3& v0, const Vec3& v1, const Vec3& v2, Hit& hit) {
    Hit candidate = no_hit();
    if (!intersect_triangle_line(ray.origin, inverse, shear, v0, v1, v2, candidate)) return false;
    if (!(ray.t_min <= candidate.t && candidate.t < ray.t_max)) return false;
    hit.t = candidate.t;
    hit.u = candidate.u;
    hit.v = candidate.v;
    return true;
}

/// Which of two hits wins: the nearer one, the lower primitive id where both are equally near.
/// Without a branch, so that loops over rays vectorise.
SCOTTY_HD bool closer(float t, std::uint32_t primitive, float than_t,
                      std::uint32_t than_primitive) {
    const int wins_tie =
        static_cast<int>(t == than_t) & static_cast<int>(primitive < than_primitive);
    return static_cast<bool>(static_cast<int>(t < than_t) | wins_tie);
}

}  // namespace scotty::reference
