/// Three-vectors: glm's storage and component-wise operators, our own products.
///
/// glm::min, glm::max, glm::normalize and glm::inversesqrt are outside the exact set (their
/// rounding differs between host and device), so kernels use the functions below and nothing else
/// of GLM.
#pragma once

#include <cmath>
#include <cstdint>

#include "reference/base/host_device.h"

#if defined(__CUDACC__)
#include <cuda.h>  // GLM looks at CUDA_VERSION
#if !defined(GLM_FORCE_CUDA)
#define GLM_FORCE_CUDA
#endif
#endif
#include <glm/vec3.hpp>

namespace scotty::reference {

using Vec3 = glm::vec3;
static_assert(sizeof(Vec3) == 12, "three packed floats");

constexpr float kPi = 3.14159265358979323846f;
constexpr float kInfinity = __builtin_huge_valf();

/// Minimum in fixed argument order: b when either is NaN.
SCOTTY_HD float min_of(float a, float b) { return a < b ? a : b; }
/// Maximum in fixed argument order: b when either is NaN.
SCOTTY_HD float max_of(float a, float b) { return a > b ? a : b; }
SCOTTY_HD float abs_of(float a) { return fabsf(a); }

/// IEEE 754's minimumNumber and maximumNumber, for values of which none is NaN: one instruction on
/// a device, where a comparison and a selection are two. Of two zeros either may come back.
SCOTTY_HD float min_number(float a, float b) {
#if defined(__CUDA_ARCH__)
    return fminf(a, b);
#else
    return min_of(a, b);
#endif
}
SCOTTY_HD float max_number(float a, float b) {
#if defined(__CUDA_ARCH__)
    return fmaxf(a, b);
#else
    return max_of(a, b);
#endif
}

SCOTTY_HD float clamp_to(float a, float low, float high) { return min_of(max_of(a, low), high); }

SCOTTY_HD Vec3 min_of(const Vec3& a, const Vec3& b) {
    return {min_of(a.x, b.x), min_of(a.y, b.y), min_of(a.z, b.z)};
}
SCOTTY_HD Vec3 max_of(const Vec3& a, const Vec3& b) {
    return {max_of(a.x, b.x), max_of(a.y, b.y), max_of(a.z, b.z)};
}
SCOTTY_HD Vec3 min_number(const Vec3& a, const Vec3& b) {
    return {min_number(a.x, b.x), min_number(a.y, b.y), min_number(a.z, b.z)};
}
SCOTTY_HD Vec3 max_number(const Vec3& a, const Vec3& b) {
    return {max_number(a.x, b.x), max_number(a.y, b.y), max_number(a.z, b.z)};
}
/// Largest magnitude of the three components.
SCOTTY_HD float max_abs(const Vec3& a) {
    return max_of(max_of(abs_of(a.x), abs_of(a.y)), abs_of(a.z));
}
SCOTTY_HD float max_component(const Vec3& a) { return max_of(max_of(a.x, a.y), a.z); }

SCOTTY_HD float dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SCOTTY_HD Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SCOTTY_HD float length(const Vec3& a) { return sqrtf(dot(a, a)); }

/// Unit vector along `a`; `fallback` (taken as it is) where `a` has no direction.
/// Scaled first, so that tiny and huge vectors neither underflow nor overflow.
SCOTTY_HD Vec3 normalize_or(const Vec3& a, const Vec3& fallback) {
    const float scale = max_abs(a);
    if (!(scale > 0.0f) || !(scale < kInfinity)) return fallback;
    const Vec3 scaled{a.x / scale, a.y / scale, a.z / scale};
    const float norm = length(scaled);
    return {scaled.x / norm, scaled.y / norm, scaled.z / norm};
}

SCOTTY_HD bool is_zero(const Vec3& a) { return a.x == 0.0f && a.y == 0.0f && a.z == 0.0f; }

}  // namespace scotty::reference
