/// Directions from uniform numbers, in exact arithmetic only (no libm).
#pragma once

#include <cmath>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"

namespace scotty::reference {

/// sin and cos for |x| <= pi/4: Taylor polynomials, within 2 units in the last place there.
struct SinCos {
    float sine, cosine;
};
SCOTTY_HD SinCos sin_cos_octant(float x) {
    const float s = x * x;
    const float sine =
        x +
        x * s * (-1.6666667e-1f + s * (8.3333333e-3f + s * (-1.9841270e-4f + s * 2.7557319e-6f)));
    const float cosine =
        1.0f + s * (-0.5f + s * (4.1666667e-2f + s * (-1.3888889e-3f + s * 2.4801587e-5f)));
    return {sine, cosine};
}

/// Uniform point on the unit disk: the concentric map of Shirley and Chiu (1997).
struct DiskPoint {
    float x, y;
};
SCOTTY_HD DiskPoint sample_disk(float u, float v) {
    const float a = 2.0f * u - 1.0f;
    const float b = 2.0f * v - 1.0f;
    if (a == 0.0f && b == 0.0f) return {0.0f, 0.0f};
    if (abs_of(a) > abs_of(b)) {
        const SinCos angle = sin_cos_octant((kPi / 4.0f) * (b / a));
        return {a * angle.cosine, a * angle.sine};
    }
    const SinCos angle = sin_cos_octant((kPi / 4.0f) * (a / b));
    return {b * angle.sine, b * angle.cosine};
}

/// Orthonormal basis around a unit normal, for every normal: Duff et al., "Building an Orthonormal
/// Basis, Revisited", JCGT 6(1), 2017.
struct Frame {
    Vec3 tangent, bitangent, normal;
};
SCOTTY_HD Frame frame_around(const Vec3& n) {
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {Vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
            Vec3(b, sign + n.y * n.y * a, -n.y), n};
}
SCOTTY_HD Vec3 to_world(const Frame& frame, float x, float y, float z) {
    return frame.tangent * x + frame.bitangent * y + frame.normal * z;
}

/// Unit direction with density cos(theta) / pi around a unit normal (Malley's method).
SCOTTY_HD Vec3 sample_cosine_hemisphere(const Vec3& normal, float u, float v) {
    const DiskPoint d = sample_disk(u, v);
    const float z = sqrtf(max_of(0.0f, 1.0f - d.x * d.x - d.y * d.y));
    return normalize_or(to_world(frame_around(normal), d.x, d.y, z), normal);
}

}  // namespace scotty::reference
