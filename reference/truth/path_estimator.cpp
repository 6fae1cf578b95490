#include "reference/truth/path_estimator.h"

#include <Random123/threefry.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace scotty::reference {

namespace {

constexpr double kOnePi = std::numbers::pi;

/// How far off a surface a ray starts, as a share of coordinates. Well above a float's rounding of
/// origins (6e-8), well below what can be seen.
constexpr double kLift = 1e-5;

Double3 exactly(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3 rounded(const Double3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
double largest(const Double3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

bool is_area(const Light& light) {
    return light.kind == LightKind::parallelogram || light.kind == LightKind::triangle;
}
bool is_sky(const Light& light) {
    return light.kind == LightKind::environment || light.kind == LightKind::hemisphere;
}

/// Lambert's cosine law by its inverse distribution: polar angle from u, azimuth from v.
Double3 cosine_direction(const Double3& normal, double u, double v) {
    const double radius = std::sqrt(u);
    const double height = std::sqrt(1.0 - u);
    const double azimuth = 2.0 * kOnePi * v;
    const Double3 other = std::abs(normal.x) < 0.5 ? Double3(1, 0, 0) : Double3(0, 1, 0);
    const Double3 tangent = glm::normalize(glm::cross(other, normal));
    const Double3 bitangent = glm::cross(normal, tangent);
    return glm::normalize(tangent * (radius * std::cos(azimuth)) +
                          bitangent * (radius * std::sin(azimuth)) + normal * height);
}

Double3 mirrored(const Double3& incoming, const Double3& normal) {
    return glm::normalize(incoming - 2.0 * glm::dot(incoming, normal) * normal);
}

/// A rough metal after Cook and Torrance, by angles: GGX facets, Smith's correlated masking,
/// Schlick's Fresnel term. All directions leave the surface.
class RoughMetal {
 public:
    explicit RoughMetal(const Material& material)
        : head_on_(exactly(material.reflectance)),
          alpha_(std::pow(std::max(material.ior, kLeastRoughness), 2.0)) {}

    /// Times the cosine at the light: what of its light goes to the viewer.
    Double3 sent(const Double3& viewer, const Double3& light, const Double3& normal) const {
        const double cos_viewer = glm::dot(viewer, normal);
        const double cos_light = glm::dot(light, normal);
        if (!(cos_viewer > 0.0) || !(cos_light > 0.0)) return Double3(0.0);
        const Double3 half = glm::normalize(viewer + light);
        const double tangent2 = tangent2_of(half, normal);
        const double cos2 = 1.0 / (1.0 + tangent2);
        const double facets = 1.0 / (kOnePi * alpha_ * alpha_ * cos2 * cos2 *
                                     std::pow(1.0 + tangent2 / (alpha_ * alpha_), 2.0));
        return reflected(glm::dot(half, light)) *
               (facets * unmasked(viewer, light, normal) / (4.0 * cos_viewer));
    }

    /// A facet by the distribution of all facets, seen or not, and the light that it reflects.
    std::pair<Double3, Double3> sample(const Double3& viewer, const Double3& normal, double u,
                                       double v) const {
        const double tangent = alpha_ * std::sqrt(u / (1.0 - u));
        const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
        const Double3 other = std::abs(normal.x) < 0.5 ? Double3(1, 0, 0) : Double3(0, 1, 0);
        const Double3 x = glm::normalize(glm::cross(other, normal));
        const Double3 y = glm::cross(normal, x);
        const double azimuth = 2.0 * kOnePi * v;
        const Double3 half =
            glm::normalize(normal + tangent * (std::cos(azimuth) * x + std::sin(azimuth) * y));
        const double along = glm::dot(viewer, half);
        const Double3 light = glm::normalize(2.0 * along * half - viewer);
        const double cos_viewer = glm::dot(viewer, normal);
        if (!(along > 0.0) || !(cos_viewer > 0.0) || !(glm::dot(light, normal) > 0.0)) {
            return {light, Double3(0.0)};
        }
        return {light, reflected(along) *
                           (unmasked(viewer, light, normal) * along / (cos_viewer * cosine))};
    }

 private:
    static double tangent2_of(const Double3& direction, const Double3& normal) {
        const double cosine = glm::dot(direction, normal);
        const Double3 sine = glm::cross(direction, normal);
        return glm::dot(sine, sine) / (cosine * cosine);
    }
    /// Smith's auxiliary function of shadowed facets.
    double shadowed(const Double3& direction, const Double3& normal) const {
        return 0.5 * (std::sqrt(1.0 + alpha_ * alpha_ * tangent2_of(direction, normal)) - 1.0);
    }
    double unmasked(const Double3& viewer, const Double3& light, const Double3& normal) const {
        return 1.0 / (1.0 + shadowed(viewer, normal) + shadowed(light, normal));
    }
    Double3 reflected(double cosine) const {
        return head_on_ + (1.0 - head_on_) * std::pow(1.0 - std::min(1.0, cosine), 5.0);
    }

    Double3 head_on_;
    double alpha_;
};

/// What an interface between two dielectrics does with a ray, after Snell and Fresnel.
struct Interface {
    double reflectance = 1.0;  ///< unpolarised; 1 at total internal reflection
    Double3 refracted{0.0};    ///< unit
};
Interface at_interface(const Double3& incoming, const Double3& normal, double n_here,
                       double n_beyond) {
    const double cos_here = std::min(1.0, std::max(0.0, -glm::dot(incoming, normal)));
    const double sin_beyond = n_here / n_beyond * std::sqrt(1.0 - cos_here * cos_here);
    if (sin_beyond >= 1.0) return {};
    const double cos_beyond = std::sqrt(1.0 - sin_beyond * sin_beyond);
    const double s =
        (n_here * cos_here - n_beyond * cos_beyond) / (n_here * cos_here + n_beyond * cos_beyond);
    const double p =
        (n_here * cos_beyond - n_beyond * cos_here) / (n_here * cos_beyond + n_beyond * cos_here);
    const Double3 along = incoming + cos_here * normal;  // its part in the surface
    return {0.5 * (s * s + p * p), glm::normalize(n_here / n_beyond * along - cos_beyond * normal)};
}

/// Share of its intensity that a spot light sends against `direction`, which points to it: one in
/// the inner cone, none beyond the outer, between them the square of a ramp in the cosine.
double share_of_spot(const Light& light, const Double3& direction) {
    const auto [inner, outer] = spot_cone(light);
    const double cosine = -glm::dot(direction, exactly(light.normal));
    if (cosine <= outer) return 0.0;
    if (cosine >= inner) return 1.0;
    const double ramp = (cosine - outer) / (double{inner} - outer);
    return ramp * ramp;
}

/// Where a line meets a parallelogram or triangle light, in front of it; infinity where nowhere.
double distance_to_light(const Light& light, const Double3& origin, const Double3& direction) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    const Double3 normal = exactly(light.normal);
    const double approach = -glm::dot(direction, normal);
    if (!(approach > 0.0)) return kNowhere;
    const Double3 corner = exactly(light.position);
    const double distance = glm::dot(origin - corner, normal) / approach;
    if (!(distance > 0.0)) return kNowhere;
    const Double3 at = origin + distance * direction - corner;
    const Double3 x = exactly(light.edge_x);
    const Double3 y = exactly(light.edge_y);
    const Double3 across = glm::cross(x, y);
    const double u = glm::dot(glm::cross(at, y), across) / glm::dot(across, across);
    const double v = glm::dot(glm::cross(x, at), across) / glm::dot(across, across);
    const bool inside = light.kind == LightKind::triangle
                            ? u >= 0.0 && v >= 0.0 && u + v <= 1.0
                            : u >= 0.0 && v >= 0.0 && u <= 1.0 && v <= 1.0;
    return inside ? distance : kNowhere;
}

}  // namespace

double PathNumbers::next() {
    if (used_ == 4) {
        const threefry4x64_ctr_t counter{{pixel_, sample_, block_++, 0}};
        const threefry4x64_key_t key{{seed_, 0x7061746874726163u, 0, 0}};  // "pathtrac"
        const threefry4x64_ctr_t bits = threefry4x64(counter, key);
        std::copy(bits.v, bits.v + 4, bits_);
        used_ = 0;
    }
    return static_cast<double>(bits_[used_++] >> 11) * 0x1p-53;
}

PathEstimator::PathEstimator(const Scene& scene, const PipelineParameters& parameters)
    : scene_(scene),
      tracer_(scene),
      parameters_(parameters),
      samples_lights_(parameters.light_samples > 0),
      scattering_finds_light_(
          std::any_of(scene.lights.begin(), scene.lights.end(),
                      [](const Light& light) { return is_area(light) || is_sky(light); })),
      coincident_(scene) {}

Double3 PathEstimator::radiance(std::uint32_t pixel, std::uint64_t sample) const {
    PathNumbers numbers(parameters_.seed, pixel, sample);
    Double3 gathered(0.0);
    Double3 throughput(1.0);
    bool seen = true;  // by the camera, perhaps in mirrors: then light sampling had no part in it
    Segment segment = camera_segment(pixel, numbers);
    std::optional<Vertex> vertex = find(segment);
    for (std::uint32_t bounce = 0;; ++bounce) {
        if (!vertex) {
            if (seen || !samples_lights_) gathered += throughput * sky(segment.direction);
            return gathered;
        }
        const Material& material = *vertex->material;
        if (vertex->front && (seen || !samples_lights_ || material.emission_is_sampled == 0)) {
            gathered += throughput * exactly(material.emission);
        }
        const bool lit = samples_lights_ && material.kind == MaterialKind::diffuse;
        // Of a metal the lights without extent: the others are found by the ray that leaves it.
        const bool metal = samples_lights_ && material.kind == MaterialKind::conductor;
        if (lit || metal) {
            gathered += throughput * light_by_lights(*vertex, segment.direction, numbers);
        }

        const bool last = bounce == parameters_.bounces;
        const bool wide_metal = metal && !is_sharp(material);
        if (last && !((lit || wide_metal) && scattering_finds_light_)) return gathered;
        const std::optional<Scattering> next = scatter(*vertex, segment.direction, numbers);
        if (!next || !(largest(throughput * next->weight) > 0.0)) return gathered;
        throughput *= next->weight;
        const double cosine = glm::dot(next->direction, vertex->shading_normal);
        segment = leave(*vertex, next->direction);
        vertex = find(segment);
        if (lit) gathered += throughput * light_by_scattering(segment, cosine, vertex);
        if (wide_metal) gathered += throughput * light_by_scattering(segment, {}, vertex);
        if (last) return gathered;
        seen = next->specular;
    }
}

PathEstimator::Segment PathEstimator::camera_segment(std::uint32_t pixel,
                                                     PathNumbers& numbers) const {
    const Camera& camera = scene_.camera;
    const double width = parameters_.image_width;
    const double height = parameters_.image_height;
    const std::uint32_t row = pixel / parameters_.image_width;
    const double x = pixel % parameters_.image_width + numbers.next();
    const double y = row + numbers.next();
    // The image plane at distance 1: its upper edge is that tangent above the middle.
    const double tangent = camera.tan_half_width > 0.0f ? camera.tan_half_width * (height / width)
                                                        : static_cast<double>(camera.tan_half_fov);
    const double pixel_size = 2.0 * tangent / height;
    const Double3 through = exactly(camera.forward) +
                            exactly(camera.right) * ((x - 0.5 * width) * pixel_size) +
                            exactly(camera.up) * ((0.5 * height - y) * pixel_size);
    return {exactly(camera.position), glm::normalize(through)};
}

std::optional<PathEstimator::Vertex> PathEstimator::find(const Segment& segment) const {
    const Ray ray{rounded(segment.origin), 0.0f, rounded(segment.direction), kInfinity};
    Hit hit = tracer_.closest(ray);
    if (!is_hit(hit)) return std::nullopt;
    hit = coincident_.seen(ray, hit);

    const auto& corner = scene_.triangles[hit.primitive];
    const Double3 v0 = exactly(scene_.vertices[corner[0]]);
    const Double3 v1 = exactly(scene_.vertices[corner[1]]);
    const Double3 v2 = exactly(scene_.vertices[corner[2]]);
    const double u = hit.u;
    const double v = hit.v;
    const Double3 area = glm::cross(v1 - v0, v2 - v0);
    if (!(glm::dot(area, area) > 0.0)) return std::nullopt;  // no inside: cannot have been hit
    const Double3 outside = glm::normalize(area);

    Vertex vertex{};
    vertex.distance = hit.t;
    vertex.position = (1.0 - u - v) * v0 + u * v1 + v * v2;
    vertex.front = glm::dot(outside, segment.direction) < 0.0;
    vertex.geometric_normal = vertex.front ? outside : -outside;
    vertex.shading_normal = vertex.geometric_normal;
    if (!scene_.normals.empty()) {
        const Double3 smooth = (1.0 - u - v) * exactly(scene_.normals[corner[0]]) +
                               u * exactly(scene_.normals[corner[1]]) +
                               v * exactly(scene_.normals[corner[2]]);
        if (glm::dot(smooth, smooth) > 0.0) {
            const Double3 facing = glm::normalize(vertex.front ? smooth : -smooth);
            // One that faces away from the viewer is not used: the surface is flat there.
            if (glm::dot(facing, segment.direction) < 0.0) vertex.shading_normal = facing;
        }
    }
    vertex.offset = kLift * std::max({largest(v0), largest(v1), largest(v2)});
    vertex.material = &scene_.materials[scene_.material_of[hit.primitive]];
    return vertex;
}

PathEstimator::Segment PathEstimator::leave(const Vertex& vertex, const Double3& direction) const {
    const double side = glm::dot(direction, vertex.geometric_normal) < 0.0 ? -1.0 : 1.0;
    return {vertex.position + side * vertex.offset * vertex.geometric_normal, direction};
}

bool PathEstimator::is_free(const Vertex& from, const Double3& to) const {
    const Double3 origin = leave(from, to - from.position).origin;
    const double distance = glm::distance(origin, to);
    return !tracer_.occluded(
        {rounded(origin), 0.0f, rounded((to - origin) / distance), static_cast<float>(distance)});
}

bool PathEstimator::is_free_towards(const Vertex& from, const Double3& direction) const {
    return !tracer_.occluded(
        {rounded(leave(from, direction).origin), 0.0f, rounded(direction), kInfinity});
}

Double3 PathEstimator::from_area_light(const Light& light, const Vertex& vertex, double u,
                                       double v) const {
    if (light.kind == LightKind::triangle && u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    const Double3 normal = exactly(light.normal);
    const Double3 on_light =
        exactly(light.position) + u * exactly(light.edge_x) + v * exactly(light.edge_y);
    const Double3 to_light = on_light - vertex.position;
    const double distance2 = glm::dot(to_light, to_light);
    if (!(distance2 > 0.0)) return Double3(0.0);
    const Double3 direction = to_light / std::sqrt(distance2);
    const double cos_light = -glm::dot(direction, normal);
    const double cosine = glm::dot(direction, vertex.shading_normal);
    if (!(cos_light > 0.0) || !(cosine > 0.0)) return Double3(0.0);
    if (!(glm::dot(direction, vertex.geometric_normal) > 0.0)) return Double3(0.0);
    // Just in front of the light, so that a lamp's own surface does not shade it.
    if (!is_free(vertex, on_light + kLift * largest(on_light) * normal)) return Double3(0.0);
    const double light_density = distance2 / (cos_light * light.area);
    const double scatter_density = cosine / kOnePi;
    return exactly(light.radiance) * (cosine / kOnePi / (light_density + scatter_density));
}

Double3 PathEstimator::light_by_lights(const Vertex& vertex, const Double3& incoming,
                                       PathNumbers& numbers) const {
    const bool metal = vertex.material->kind == MaterialKind::conductor;
    Double3 sent(0.0);
    for (const Light& light : scene_.lights) {
        if (is_area(light)) {
            if (metal) continue;
            const double u = numbers.next();
            const double v = numbers.next();
            sent += exactly(vertex.material->reflectance) * from_area_light(light, vertex, u, v);
            continue;
        }
        if (is_sky(light)) continue;
        const bool is_spot = light.kind == LightKind::spot;
        const bool is_point = is_spot || light.kind == LightKind::point;
        const Double3 to_light =
            is_point ? exactly(light.position) - vertex.position : -exactly(light.normal);
        const double distance2 = glm::dot(to_light, to_light);
        if (!(distance2 > 0.0)) continue;
        const Double3 direction = to_light / std::sqrt(distance2);
        const double cosine = glm::dot(direction, vertex.shading_normal);
        if (!(cosine > 0.0) || !(glm::dot(direction, vertex.geometric_normal) > 0.0)) continue;
        const double share = is_spot ? share_of_spot(light, direction) : 1.0;
        if (!(share > 0.0)) continue;
        const bool is_lit = is_point ? is_free(vertex, exactly(light.position))
                                     : is_free_towards(vertex, direction);
        if (!is_lit) continue;
        const Double3 towards_viewer =
            metal ? RoughMetal(*vertex.material).sent(-incoming, direction, vertex.shading_normal)
                  : exactly(vertex.material->reflectance) * (cosine / kOnePi);
        sent += towards_viewer * exactly(light.radiance) * (share / (is_point ? distance2 : 1.0));
    }
    return sent;
}

Double3 PathEstimator::light_by_scattering(const Segment& segment, std::optional<double> cosine,
                                           const std::optional<Vertex>& next) const {
    Double3 arriving(0.0);
    if (!next) arriving += sky(segment.direction);
    const double scatter_density = cosine.value_or(0.0) / kOnePi;
    for (const Light& light : scene_.lights) {
        if (!is_area(light)) continue;
        const double distance = distance_to_light(light, segment.origin, segment.direction);
        if (!(distance < std::numeric_limits<double>::infinity())) continue;
        const double cos_light = -glm::dot(segment.direction, exactly(light.normal));
        const Double3 on_light = segment.origin + distance * segment.direction;
        const double in_front = distance - kLift * largest(on_light) / cos_light;
        if (next && next->distance < in_front) continue;
        const double light_density = distance * distance / (cos_light * light.area);
        const double share = cosine ? scatter_density / (light_density + scatter_density) : 1.0;
        arriving += exactly(light.radiance) * share;
    }
    return arriving;
}

Double3 PathEstimator::sky(const Double3& direction) const {
    Double3 radiance(0.0);
    for (const Light& light : scene_.lights) {
        const bool shines = light.kind == LightKind::environment ||
                            (light.kind == LightKind::hemisphere &&
                             glm::dot(direction, exactly(light.normal)) > 0.0);
        if (shines) radiance += exactly(light.radiance);
    }
    return radiance;
}

std::optional<PathEstimator::Scattering> PathEstimator::scatter(const Vertex& vertex,
                                                                const Double3& incoming,
                                                                PathNumbers& numbers) const {
    const Material& material = *vertex.material;
    const double first = numbers.next();
    const double second = numbers.next();
    if (material.kind == MaterialKind::diffuse) {
        const Double3 out = cosine_direction(vertex.shading_normal, first, second);
        // A smooth normal's hemisphere reaches below the surface: that part is absorbed.
        if (!(glm::dot(out, vertex.geometric_normal) > 0.0)) return std::nullopt;
        return Scattering{out, exactly(material.reflectance), false};
    }
    if (material.kind == MaterialKind::conductor) {
        const auto [out, weight] =
            RoughMetal(material).sample(-incoming, vertex.shading_normal, first, second);
        if (!(glm::dot(out, vertex.geometric_normal) > 0.0)) return std::nullopt;
        return Scattering{out, weight, is_sharp(material)};
    }
    // By the smooth normal first; where that leads to the wrong side, by the flat one, which
    // cannot. The number that chose between reflection and refraction chooses again.
    for (const Double3& normal : {vertex.shading_normal, vertex.geometric_normal}) {
        const double n_here = vertex.front ? 1.0 : material.ior;
        const double n_beyond = vertex.front ? material.ior : 1.0;
        const bool is_glass = material.kind == MaterialKind::glass;
        const Interface surface =
            is_glass ? at_interface(incoming, normal, n_here, n_beyond) : Interface{};
        const bool reflects = first < surface.reflectance;
        const Double3 out = reflects ? mirrored(incoming, normal) : surface.refracted;
        const bool crosses = glm::dot(out, vertex.geometric_normal) < 0.0;
        if (crosses == reflects) continue;
        // Radiance over n squared is what stays the same across an interface.
        const Double3 weight =
            reflects ? exactly(material.reflectance)
                     : exactly(material.transmittance) * (n_here * n_here / (n_beyond * n_beyond));
        return Scattering{out, weight, true};
    }
    return std::nullopt;
}

}  // namespace scotty::reference
