/// One path, vertex by vertex: what the shading kernels compute for one ray id.
///
/// Pure functions of their arguments. The pipelines call them from kernels, the Embree renderer
/// from a plain loop; equal hits give equal bits.
#pragma once

#include "reference/base/host_device.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/scene.h"
#include "reference/numerics/bsdf.h"
#include "reference/numerics/light_sampling.h"
#include "reference/numerics/rng.h"
#include "reference/numerics/surface.h"

namespace scotty::reference {

/// What the shading kernels need of the parameters.
struct PathParameters {
    std::uint64_t seed = 0;
    std::uint32_t image_width = 1;
    std::uint32_t image_height = 1;
    std::uint32_t light_samples = 2;
    std::uint32_t bounces = 2;
    std::uint32_t roulette = 0;
};
inline PathParameters path_parameters(const PipelineParameters& p) {
    return {p.seed, p.image_width, p.image_height, p.light_samples, p.bounces, p.roulette};
}

/// Tangent of half the vertical field of view in an image of this shape.
SCOTTY_HD float vertical_tangent(const Camera& camera, float width, float height) {
    return camera.tan_half_width > 0.0f ? camera.tan_half_width * (height / width)
                                        : camera.tan_half_fov;
}

/// Camera ray through a random point of a pixel; y runs downwards, (0, 0) is the top left.
SCOTTY_HD Ray primary_ray(const Camera& camera, const PathParameters& parameters,
                          std::uint32_t pixel, std::uint32_t sample) {
    const Random4 random =
        random4(parameters.seed, pixel, sample, 0, static_cast<std::uint32_t>(Dimension::camera));
    const auto width = static_cast<float>(parameters.image_width);
    const auto height = static_cast<float>(parameters.image_height);
    const std::uint32_t row = pixel / parameters.image_width;
    const float x = static_cast<float>(pixel % parameters.image_width) + random.a;
    const float y = static_cast<float>(row) + random.b;
    const float tangent = vertical_tangent(camera, width, height);
    const float across = (2.0f * (x / width) - 1.0f) * (tangent * (width / height));
    const float upward = (1.0f - 2.0f * (y / height)) * tangent;
    const Vec3 direction = camera.forward + camera.right * across + camera.up * upward;
    return {camera.position, 0.0f, normalize_or(direction, camera.forward), kInfinity};
}

/// True where emission met at this vertex has not been accounted for by light sampling.
SCOTTY_HD bool counts_emission(std::uint32_t bounce, std::uint32_t flags, bool is_sampled,
                               const PathParameters& parameters) {
    const bool seen_directly = bounce == 0 || (flags & kPathSpecular) != 0;
    return seen_directly || !is_sampled || parameters.light_samples == 0;
}

struct DirectLight {
    Ray shadow;      ///< dead where there is nothing to ask
    Vec3 potential;  ///< radiance to add to the pixel's path if nothing is in the way
};

SCOTTY_HD DirectLight no_direct_light() { return {dead_ray(), Vec3(0.0f, 0.0f, 0.0f)}; }

/// One direct-light sample at the surface that a path has met in this direction.
SCOTTY_HD DirectLight sample_light_at(const SceneView& scene, const PathParameters& parameters,
                                      const Surface& surface, const Vec3& direction,
                                      const Vec3& throughput, const Random4& random) {
    const DirectLight nothing = no_direct_light();
    if (scene.light_count == 0) return nothing;
    const Material& material = scene.materials[surface.material];
    if (is_smooth(material)) return nothing;

    const auto count = static_cast<float>(scene.light_count);
    const auto picked = static_cast<std::uint32_t>(random.a * count);
    const std::uint32_t index = picked < scene.light_count ? picked : scene.light_count - 1;
    if (is_sharp(material) && has_extent(scene.lights[index].kind)) return nothing;
    const LightSample light = sample_light(scene.lights[index], surface, random.b, random.c);
    const float cosine = dot(light.direction, surface.shading_normal);
    if (!(cosine > 0.0f) || !(dot(light.direction, surface.geometric_normal) > 0.0f)) {
        return nothing;
    }
    const float weight = cosine * count / (kPi * static_cast<float>(parameters.light_samples));
    const Vec3 value =
        evaluate_bsdf(material, direction * -1.0f, light.direction, surface.shading_normal);
    const Vec3 potential = throughput * value * light.irradiance * weight;
    if (!(max_component(potential) > 0.0f)) return nothing;
    return {shadow_ray(surface, light), potential};
}
/// The same at a path vertex (the 2018 paper's "direct light ray generation").
SCOTTY_HD DirectLight sample_direct_light(const SceneView& scene, const PathParameters& parameters,
                                          const Ray& ray, const Hit& hit, const Vec3& throughput,
                                          const Random4& random) {
    if (!is_hit(hit) || scene.light_count == 0) return no_direct_light();
    return sample_light_at(scene, parameters, surface_at(scene, ray, hit), ray.direction,
                           throughput, random);
}

/// Russian roulette: the probability with which a path that carries this throughput goes on after
/// its `scatterings`-th scattering. 1: it always does.
SCOTTY_HD float survival(const PathParameters& parameters, std::uint32_t scatterings,
                         const Vec3& carried) {
    if (parameters.roulette == 0 || scatterings < parameters.roulette) return 1.0f;
    return clamp_to(max_component(carried), 0.0f, 1.0f);
}

struct Scattered {
    Ray ray;          ///< the path's next ray; dead where it ends
    Vec3 throughput;  ///< of the next ray
    Vec3 emitted;     ///< radiance to add for what the path has met at this vertex
    std::uint32_t flags;
};

SCOTTY_HD Scattered path_end() {
    return {dead_ray(), Vec3(0.0f, 0.0f, 0.0f), Vec3(0.0f, 0.0f, 0.0f), 0};
}

/// A path that leaves the scene keeps what it has gathered.
SCOTTY_HD Scattered leave_scene(const SceneView& scene, const PathParameters& parameters,
                                std::uint32_t bounce, const Vec3& direction, const Vec3& throughput,
                                std::uint32_t flags) {
    Scattered end = path_end();
    if (counts_emission(bounce, flags, true, parameters)) {
        end.emitted = throughput * distant_radiance(scene, direction);
    }
    return end;
}

/// Emission and the next ray at the surface that a path has met in this direction.
SCOTTY_HD Scattered scatter_at(const SceneView& scene, const PathParameters& parameters,
                               std::uint32_t bounce, const Surface& surface, const Vec3& direction,
                               const Vec3& throughput, std::uint32_t flags, const Random4& random) {
    Scattered end = path_end();
    const Material& material = scene.materials[surface.material];
    if (surface.front &&
        counts_emission(bounce, flags, material.emission_is_sampled != 0, parameters)) {
        end.emitted = throughput * material.emission;
    }
    if (bounce >= parameters.bounces) return end;

    BsdfSample next =
        sample_bsdf(material, direction, surface.shading_normal, surface.front, random);
    // A smooth normal can send the ray through the surface it should leave, or back from the one
    // it should pass: smooth materials fall back to the flat normal, all others absorb.
    const bool crosses = dot(next.direction, surface.geometric_normal) < 0.0f;
    if (crosses != next.transmitted) {
        if (!is_smooth(material)) return end;
        next = sample_bsdf(material, direction, surface.geometric_normal, surface.front, random);
    }
    Vec3 carried = throughput * next.weight;
    if (!(max_component(carried) > 0.0f)) return end;
    const float survives = survival(parameters, bounce + 1, carried);
    if (survives < 1.0f) {
        if (!(random.d < survives)) return end;
        carried = carried * (1.0f / survives);
    }
    return {leave_surface(surface, next.direction, kInfinity), carried, end.emitted,
            kPathAlive | (next.specular ? kPathSpecular : 0u)};
}

/// Emission at a path vertex and the next ray (the 2018 paper's "scene ray generation").
SCOTTY_HD Scattered scatter(const SceneView& scene, const PathParameters& parameters,
                            std::uint32_t bounce, const Ray& ray, const Hit& hit,
                            const Vec3& throughput, std::uint32_t flags, const Random4& random) {
    if ((flags & kPathAlive) == 0) return path_end();
    if (!is_hit(hit)) {
        return leave_scene(scene, parameters, bounce, ray.direction, throughput, flags);
    }
    return scatter_at(scene, parameters, bounce, surface_at(scene, ray, hit), ray.direction,
                      throughput, flags, random);
}

}  // namespace scotty::reference
