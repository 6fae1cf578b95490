/// Diffuse, mirror and glass: one sampled direction and its weight (BSDF x cosine / density).
#pragma once

#include <cmath>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/numerics/rng.h"
#include "reference/numerics/sampling.h"

namespace scotty::reference {

/// Mirror direction of an incoming unit direction `d` (towards the surface).
SCOTTY_HD Vec3 reflect(const Vec3& d, const Vec3& n) { return d - n * (2.0f * dot(d, n)); }

/// Refracted direction by Snell's law. `n` faces against `d`; eta = ior here / ior beyond.
/// Returns false at total internal reflection.
SCOTTY_HD bool refract(const Vec3& d, const Vec3& n, float eta, Vec3& refracted) {
    const float cos_in = -dot(d, n);
    const float sin2_out = eta * eta * max_of(0.0f, 1.0f - cos_in * cos_in);
    if (!(sin2_out < 1.0f)) return false;
    const float cos_out = sqrtf(1.0f - sin2_out);
    refracted = d * eta + n * (eta * cos_in - cos_out);
    return true;
}

/// Unpolarised Fresnel reflectance of a dielectric; 1 at total internal reflection.
SCOTTY_HD float fresnel_dielectric(float cos_in, float eta) {
    const float sin2_out = eta * eta * max_of(0.0f, 1.0f - cos_in * cos_in);
    if (!(sin2_out < 1.0f)) return 1.0f;
    const float cos_out = sqrtf(1.0f - sin2_out);
    const float parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    const float perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

struct BsdfSample {
    Vec3 direction;  ///< unit
    Vec3 weight;     ///< zero: absorbed
    bool specular;
    bool transmitted;
};

/// Samples the material at a point seen along the unit direction `d`. `normal` is unit and faces
/// against d; `front` says whether d arrives at the outside (winding) of the surface.
SCOTTY_HD BsdfSample sample_bsdf(const Material& material, const Vec3& d, const Vec3& normal,
                                 bool front, const Random4& random) {
    if (material.kind == MaterialKind::diffuse) {
        return {sample_cosine_hemisphere(normal, random.a, random.b), material.reflectance, false,
                false};
    }
    if (material.kind == MaterialKind::mirror) {
        return {normalize_or(reflect(d, normal), normal), material.reflectance, true, false};
    }
    const float eta = front ? 1.0f / material.ior : material.ior;
    const float cos_in = clamp_to(-dot(d, normal), 0.0f, 1.0f);
    const float reflectance = fresnel_dielectric(cos_in, eta);
    Vec3 through(0.0f, 0.0f, 0.0f);
    if (random.c < reflectance || !refract(d, normal, eta, through)) {
        return {normalize_or(reflect(d, normal), normal), material.reflectance, true, false};
    }
    // Radiance is compressed by the solid angle when it crosses the interface.
    return {normalize_or(through, d), material.transmittance * (eta * eta), true, true};
}

}  // namespace scotty::reference
