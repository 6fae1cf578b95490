/// One sample of one light, as seen from a surface point.
#pragma once

#include <cmath>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/numerics/rng.h"
#include "reference/numerics/sampling.h"
#include "reference/numerics/surface.h"

namespace scotty::reference {

struct LightSample {
    Vec3 direction;   ///< unit, towards the light
    float distance;   ///< to the sampled point, just short of it; +infinity for distant lights
    Vec3 irradiance;  ///< radiance / density of the direction; times cosine at the surface = light
};

SCOTTY_HD LightSample no_light() { return {Vec3(0.0f, 0.0f, 1.0f), 0.0f, Vec3(0.0f, 0.0f, 0.0f)}; }

/// Area lights: uniform by area. `u`, `v` in [0, 1).
SCOTTY_HD LightSample sample_area_light(const Light& light, const Vec3& from, float u, float v) {
    if (light.kind == LightKind::triangle && u + v > 1.0f) {
        u = 1.0f - u;
        v = 1.0f - v;
    }
    const Vec3 on_light = light.position + light.edge_x * u + light.edge_y * v;
    // Off the light's front by more than the rounding at both ends of the shadow ray, so that
    // geometry in the light's own plane does not shadow it.
    const float offset = kSurfaceOffset * max_of(max_abs(on_light), max_abs(from));
    const Vec3 target = on_light + light.normal * offset;
    const Vec3 to_light = target - from;
    const float distance2 = dot(to_light, to_light);
    const float distance = sqrtf(distance2);
    if (!(distance2 > 0.0f)) return no_light();
    const Vec3 direction = normalize_or(to_light, light.normal);
    const float cos_light = -dot(direction, light.normal);
    if (!(cos_light > 0.0f)) return no_light();
    return {direction, distance, light.radiance * (cos_light * light.area / distance2)};
}

/// The ray that asks whether a surface sees a light sample. It starts off the surface and is
/// therefore aimed anew: on the sample's own course it would end beyond the light, in its shadow.
SCOTTY_HD Ray shadow_ray(const Surface& surface, const LightSample& light) {
    Ray ray = leave_surface(surface, light.direction, light.distance);
    if (!(light.distance < kInfinity)) return ray;
    const Vec3 target = surface.position + light.direction * light.distance;
    const Vec3 to_light = target - ray.origin;
    ray.direction = normalize_or(to_light, light.direction);
    ray.t_max = length(to_light);
    return ray;
}

/// Radiance that arrives from outside the scene along a ray of that direction.
SCOTTY_HD Vec3 distant_radiance(const SceneView& scene, const Vec3& direction) {
    return dot(direction, scene.hemisphere_up) > 0.0f ? scene.environment + scene.hemisphere
                                                      : scene.environment;
}

/// Share of a spot light's intensity in a direction whose cosine to the light's is `cosine`: the
/// square of a ramp from the outer cosine to the inner one (KHR_lights_punctual, "Inner and outer
/// cone angles").
SCOTTY_HD float spot_falloff(const SpotCone& cone, float cosine) {
    if (!(cosine > cone.outer)) return 0.0f;
    if (cosine >= cone.inner) return 1.0f;
    const float ramp = (cosine - cone.outer) / (cone.inner - cone.outer);
    return ramp * ramp;
}

/// Samples one light from a surface. Black (irradiance zero) where the light cannot reach it.
SCOTTY_HD LightSample sample_light(const Light& light, const Surface& surface, float u, float v) {
    if (light.kind == LightKind::parallelogram || light.kind == LightKind::triangle) {
        return sample_area_light(light, surface.position, u, v);
    }
    if (light.kind == LightKind::point || light.kind == LightKind::spot) {
        const Vec3 to_light = light.position - surface.position;
        const float distance2 = dot(to_light, to_light);
        if (!(distance2 > 0.0f)) return no_light();
        const Vec3 direction = normalize_or(to_light, surface.shading_normal);
        if (light.kind == LightKind::point) {
            return {direction, sqrtf(distance2), light.radiance / distance2};
        }
        const float falloff = spot_falloff(spot_cone(light), -dot(direction, light.normal));
        if (!(falloff > 0.0f)) return no_light();
        return {direction, sqrtf(distance2), light.radiance * (falloff / distance2)};
    }
    if (light.kind == LightKind::directional) {
        return {light.normal * -1.0f, kInfinity, light.radiance};
    }
    const Vec3 direction = sample_cosine_hemisphere(surface.shading_normal, u, v);
    const float cosine = dot(direction, surface.shading_normal);
    if (!(cosine > 0.0f)) return no_light();
    if (light.kind == LightKind::hemisphere && !(dot(direction, light.normal) > 0.0f)) {
        return no_light();
    }
    return {direction, kInfinity, light.radiance * (kPi / cosine)};
}

}  // namespace scotty::reference
