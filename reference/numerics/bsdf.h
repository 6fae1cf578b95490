/// Diffuse, mirror, glass and rough metal: the value of a BSDF, and one sampled direction with its
/// weight (BSDF x cosine / density).
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

/// The GGX distribution of microfacet normals (Walter et al. 2007), isotropic, in a frame whose z
/// is the surface's normal; alpha is the square of the roughness.
SCOTTY_HD float ggx_alpha2(const Material& material) {
    const float roughness = max_of(material.ior, kLeastRoughness);
    const float alpha = roughness * roughness;
    return alpha * alpha;
}
/// The cosine of a direction times sqrt(1 + alpha^2 tan^2), of which Smith's masking is made.
SCOTTY_HD float smith_cosine(float alpha2, float cosine) {
    return sqrtf(cosine * cosine + alpha2 * max_of(0.0f, 1.0f - cosine * cosine));
}
/// Schlick's approximation of a conductor's Fresnel reflectance.
SCOTTY_HD Vec3 fresnel_schlick(const Vec3& head_on, float cosine) {
    const float x = clamp_to(1.0f - cosine, 0.0f, 1.0f);
    const float x2 = x * x;
    return head_on + (Vec3(1.0f, 1.0f, 1.0f) - head_on) * (x2 * x2 * x);
}

/// The BSDF's value times pi, which is a diffuse surface's albedo, for unit directions that leave
/// the surface on the side of its unit normal. Zero where the material has no values.
SCOTTY_HD Vec3 evaluate_bsdf(const Material& material, const Vec3& to_viewer, const Vec3& to_light,
                             const Vec3& normal) {
    const Vec3 none(0.0f, 0.0f, 0.0f);
    if (material.kind == MaterialKind::diffuse) return material.reflectance;
    if (material.kind != MaterialKind::conductor) return none;
    const float cos_viewer = dot(to_viewer, normal);
    const float cos_light = dot(to_light, normal);
    if (!(cos_viewer > 0.0f) || !(cos_light > 0.0f)) return none;
    const Vec3 half = normalize_or(to_viewer + to_light, normal);
    const float cos_half = dot(half, normal);
    const Vec3 across = cross(half, normal);  // its length is the sine: exact where that is small
    const float alpha2 = ggx_alpha2(material);
    const float spread = dot(across, across) + alpha2 * (cos_half * cos_half);
    const float density = alpha2 / (spread * spread);  // of microfacets, times pi
    const float masking =
        smith_cosine(alpha2, cos_viewer) * cos_light + smith_cosine(alpha2, cos_light) * cos_viewer;
    return fresnel_schlick(material.reflectance, dot(half, to_light)) *
           (density / (2.0f * masking));
}

/// A normal of the microfacets that are seen from `to_viewer` (Heitz 2018, "Sampling the GGX
/// Distribution of Visible Normals"). Requires dot(to_viewer, frame.normal) >= 0.
SCOTTY_HD Vec3 sample_visible_normal(const Frame& frame, const Vec3& to_viewer, float alpha,
                                     float u, float v) {
    const float x = alpha * dot(to_viewer, frame.tangent);
    const float y = alpha * dot(to_viewer, frame.bitangent);
    const Vec3 stretched =
        normalize_or(Vec3(x, y, dot(to_viewer, frame.normal)), Vec3(0.0f, 0.0f, 1.0f));
    const float flat = stretched.x * stretched.x + stretched.y * stretched.y;
    const Vec3 first = flat > 0.0f ? Vec3(-stretched.y, stretched.x, 0.0f) * (1.0f / sqrtf(flat))
                                   : Vec3(1.0f, 0.0f, 0.0f);
    const Vec3 second = cross(stretched, first);
    const DiskPoint p = sample_disk(u, v);
    const float share = 0.5f * (1.0f + stretched.z);
    const float q = (1.0f - share) * sqrtf(max_of(0.0f, 1.0f - p.x * p.x)) + share * p.y;
    const float up = sqrtf(max_of(0.0f, 1.0f - p.x * p.x - q * q));
    const Vec3 normal = first * p.x + second * q + stretched * up;
    return normalize_or(to_world(frame, alpha * normal.x, alpha * normal.y, max_of(0.0f, normal.z)),
                        frame.normal);
}

struct BsdfSample {
    Vec3 direction;  ///< unit
    Vec3 weight;     ///< zero: absorbed
    bool specular;   ///< is_sharp()
    bool transmitted;
};

SCOTTY_HD BsdfSample sample_conductor(const Material& material, const Vec3& d, const Vec3& normal,
                                      const Random4& random) {
    const Vec3 to_viewer = d * -1.0f;
    const float alpha2 = ggx_alpha2(material);
    const Vec3 facet =
        sample_visible_normal(frame_around(normal), to_viewer, sqrtf(alpha2), random.a, random.b);
    BsdfSample sample{normalize_or(reflect(d, facet), normal), Vec3(0.0f, 0.0f, 0.0f),
                      is_sharp(material), false};
    const float cos_viewer = dot(to_viewer, normal);
    const float cos_light = dot(sample.direction, normal);
    if (!(cos_viewer > 0.0f) || !(cos_light > 0.0f)) return sample;  // masked
    // Of the light that the visible facets send there, what is not masked on its way out.
    const float seen = cos_light * (cos_viewer + smith_cosine(alpha2, cos_viewer));
    const float both =
        smith_cosine(alpha2, cos_viewer) * cos_light + smith_cosine(alpha2, cos_light) * cos_viewer;
    sample.weight =
        fresnel_schlick(material.reflectance, dot(facet, sample.direction)) * (seen / both);
    return sample;
}

/// Samples the material at a point seen along the unit direction `d`. `normal` is unit and faces
/// against d; `front` says whether d arrives at the outside (winding) of the surface.
SCOTTY_HD BsdfSample sample_bsdf(const Material& material, const Vec3& d, const Vec3& normal,
                                 bool front, const Random4& random) {
    if (material.kind == MaterialKind::diffuse) {
        return {sample_cosine_hemisphere(normal, random.a, random.b), material.reflectance, false,
                false};
    }
    if (material.kind == MaterialKind::conductor) {
        return sample_conductor(material, d, normal, random);
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
