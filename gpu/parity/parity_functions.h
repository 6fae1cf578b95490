/// The expressions that the parity test runs on both sides: six floats in, up to eight words out.
///
/// Host and device compile this same text; what is compared is their results.
#pragma once

#include <cstdint>
#include <cstring>

#include "reference/numerics/bsdf.h"
#include "reference/numerics/exponential.h"
#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/numerics/light_sampling.h"
#include "reference/numerics/path.h"
#include "reference/numerics/rng.h"
#include "reference/numerics/sampling.h"

namespace scotty::gpu {

struct ParityOperands {
    float x[12];
};
struct ParityWords {
    std::uint32_t word[9];
};

SCOTTY_HD std::uint32_t parity_bits(float value) {
    std::uint32_t bits = 0;
    memcpy(&bits, &value, sizeof(bits));
    return value != value ? 0x7fc00000u : bits;  // NaN payloads are nobody's promise
}
SCOTTY_HD void put(ParityWords& out, int at, const reference::Vec3& v) {
    out.word[at] = parity_bits(v.x);
    out.word[at + 1] = parity_bits(v.y);
    out.word[at + 2] = parity_bits(v.z);
}

enum class ParityCase : std::uint32_t {
    add,
    subtract,
    multiply,
    divide,
    square_root,
    fused_multiply_add,
    multiply_then_add,
    minimum_maximum,
    safe_inverse,
    normalize,
    cross_dot,
    slab_test,
    triangle_test,
    random_numbers,
    disk_and_hemisphere,
    frame,
    exponential,
    fresnel_refract,
    sample_bsdf,
    area_light,
    primary_ray,
    count
};

constexpr const char* kParityNames[] = {
    "add",          "subtract",           "multiply",           "divide",       "square_root",
    "fma",          "multiply, then add", "minimum, maximum",   "safe_inverse", "normalize_or",
    "cross, dot",   "intersect_box",      "intersect_triangle", "random4",      "disk, hemisphere",
    "frame_around", "exp_minus",          "fresnel, refract",   "sample_bsdf",  "sample_area_light",
    "primary_ray"};

/// A number in [0, 1) made of an operand's bits (of NaN, whose bits nobody promises, of one kind).
SCOTTY_HD float unit_of(float x) {
    return reference::to_unit_interval(parity_bits(x) * 2654435761u);
}
SCOTTY_HD reference::Vec3 unit_vector_of(float a, float b) {
    const float z = 2.0f * unit_of(a) - 1.0f;
    return reference::normalize_or(
        reference::Vec3(2.0f * unit_of(b) - 1.0f, 2.0f * unit_of(a + b) - 1.0f, z),
        reference::Vec3(0.0f, 0.0f, 1.0f));
}

/// Coordinates as scenes may have them: what minimum and maximum of numbers are promised for.
SCOTTY_HD float coordinate_of(float x) {
    return reference::abs_of(x) <= reference::kMaxCoordinate ? x : 0.0f;
}
SCOTTY_HD reference::Vec3 coordinates_of(const reference::Vec3& v) {
    return {coordinate_of(v.x), coordinate_of(v.y), coordinate_of(v.z)};
}

SCOTTY_HD ParityWords parity_case(ParityCase which, const ParityOperands& o) {
    using reference::Vec3;
    ParityWords out{};
    const float* x = o.x;
    const Vec3 a(x[0], x[1], x[2]);
    const Vec3 b(x[3], x[4], x[5]);
    const Vec3 c(x[6], x[7], x[8]);
    const Vec3 d(x[9], x[10], x[11]);
    switch (which) {
        case ParityCase::add:
            out.word[0] = parity_bits(x[0] + x[1]);
            break;
        case ParityCase::subtract:
            out.word[0] = parity_bits(x[0] - x[1]);
            break;
        case ParityCase::multiply:
            out.word[0] = parity_bits(x[0] * x[1]);
            break;
        case ParityCase::divide:
            out.word[0] = parity_bits(x[0] / x[1]);
            break;
        case ParityCase::square_root:
            out.word[0] = parity_bits(sqrtf(x[0]));
            break;
        case ParityCase::fused_multiply_add:
            out.word[0] = parity_bits(fmaf(x[0], x[1], x[2]));
            break;
        case ParityCase::multiply_then_add:
            out.word[0] = parity_bits(x[0] * x[1] + x[2]);
            break;
        case ParityCase::minimum_maximum:
            out.word[0] = parity_bits(reference::min_of(x[0], x[1]));
            out.word[1] = parity_bits(reference::max_of(x[0], x[1]));
            break;
        case ParityCase::safe_inverse:
            out.word[0] = parity_bits(reference::safe_inverse(x[0]));
            break;
        case ParityCase::normalize:
            put(out, 0, reference::normalize_or(a, b));
            break;
        case ParityCase::cross_dot:
            put(out, 0, reference::cross(a, b));
            out.word[3] = parity_bits(reference::dot(a, b));
            break;
        case ParityCase::slab_test: {
            const Vec3 origin = coordinates_of(a);
            const Vec3 low = reference::min_of(coordinates_of(b), coordinates_of(c));
            const Vec3 high = reference::max_of(coordinates_of(b), coordinates_of(c));
            const reference::BoxInterval interval = reference::intersect_box(
                reference::ray_slabs(origin, reference::safe_inverse(d),
                                     reference::box_pad(origin, low, high)),
                low, high);
            // Of two zeros either may be the less or the greater.
            out.word[0] = parity_bits(interval.entry + 0.0f);
            out.word[1] = parity_bits(interval.exit + 0.0f);
            break;
        }
        case ParityCase::triangle_test: {
            // Aimed at the triangle, so that most of it is exercised.
            const float u = unit_of(x[9]), v = unit_of(x[10]) * (1.0f - u);
            const Vec3 origin = coordinates_of(a);
            const Vec3 v0 = coordinates_of(b), v1 = coordinates_of(c), v2 = coordinates_of(d);
            const Vec3 direction = v0 * (1.0f - u - v) + v1 * u + v2 * v - origin;
            reference::Hit hit = reference::no_hit();
            const bool found = reference::intersect_triangle_line(
                origin, reference::safe_inverse(direction), reference::ray_shear(direction), v0, v1,
                v2, hit);
            out.word[0] = found ? 1u : 0u;
            out.word[1] = parity_bits(hit.t);
            out.word[2] = parity_bits(hit.u);
            out.word[3] = parity_bits(hit.v);
            break;
        }
        case ParityCase::random_numbers: {
            const reference::Random4 r =
                reference::random4(parity_bits(x[0]), parity_bits(x[1]), parity_bits(x[2]),
                                   parity_bits(x[3]), parity_bits(x[4]));
            put(out, 0, Vec3(r.a, r.b, r.c));
            out.word[3] = parity_bits(r.d);
            break;
        }
        case ParityCase::disk_and_hemisphere: {
            const reference::DiskPoint p = reference::sample_disk(unit_of(x[0]), unit_of(x[1]));
            out.word[0] = parity_bits(p.x);
            out.word[1] = parity_bits(p.y);
            put(out, 2,
                reference::sample_cosine_hemisphere(unit_vector_of(x[2], x[3]), unit_of(x[0]),
                                                    unit_of(x[1])));
            break;
        }
        case ParityCase::frame: {
            const reference::Frame frame = reference::frame_around(unit_vector_of(x[0], x[1]));
            put(out, 0, frame.tangent);
            put(out, 3, frame.bitangent);
            break;
        }
        case ParityCase::exponential:
            out.word[0] = parity_bits(reference::exp_minus(100.0f * unit_of(x[0])));
            break;
        case ParityCase::fresnel_refract: {
            const float eta = 0.4f + 2.0f * unit_of(x[2]);
            const Vec3 normal = unit_vector_of(x[0], x[1]);
            Vec3 incoming = unit_vector_of(x[3], x[4]);
            if (reference::dot(incoming, normal) > 0.0f) incoming = incoming * -1.0f;
            Vec3 refracted(0.0f, 0.0f, 0.0f);
            out.word[0] = reference::refract(incoming, normal, eta, refracted) ? 1u : 0u;
            put(out, 1, refracted);
            out.word[4] =
                parity_bits(reference::fresnel_dielectric(-reference::dot(incoming, normal), eta));
            break;
        }
        case ParityCase::sample_bsdf: {
            reference::Material material;
            const auto kind = static_cast<std::uint32_t>(4.0f * unit_of(x[5]));
            material.kind = static_cast<reference::MaterialKind>(kind);
            material.reflectance = Vec3(unit_of(x[6]), unit_of(x[7]), unit_of(x[8]));
            material.transmittance = material.reflectance;
            const bool rough = material.kind == reference::MaterialKind::conductor;
            material.ior = rough ? unit_of(x[9]) : 1.0f + unit_of(x[9]);
            const Vec3 normal = unit_vector_of(x[0], x[1]);
            Vec3 incoming = unit_vector_of(x[3], x[4]);
            if (reference::dot(incoming, normal) > 0.0f) incoming = incoming * -1.0f;
            const reference::BsdfSample sample =
                reference::sample_bsdf(material, incoming, normal, unit_of(x[10]) < 0.5f,
                                       {unit_of(x[2]), unit_of(x[5]), unit_of(x[11]), 0.0f});
            put(out, 0, sample.direction);
            put(out, 3, sample.weight);
            put(out, 6,
                reference::evaluate_bsdf(material, incoming * -1.0f, sample.direction, normal));
            break;
        }
        case ParityCase::area_light: {
            reference::Light light;
            light.kind = unit_of(x[11]) < 0.5f ? reference::LightKind::parallelogram
                                               : reference::LightKind::triangle;
            light.position = a;
            light.edge_x = b;
            light.edge_y = c;
            light.normal = reference::normalize_or(reference::cross(b, c), Vec3(0.0f, 0.0f, 1.0f));
            light.area = reference::length(reference::cross(b, c));
            light.radiance = Vec3(1.0f, 2.0f, 3.0f);
            const reference::LightSample sample =
                reference::sample_area_light(light, d, unit_of(x[0]), unit_of(x[1]));
            put(out, 0, sample.direction);
            put(out, 3, sample.irradiance);
            out.word[6] = parity_bits(sample.distance);
            break;
        }
        case ParityCase::primary_ray: {
            reference::PathParameters parameters;
            parameters.image_width = 1 + parity_bits(x[0]) % 4096;
            parameters.image_height = 1 + parity_bits(x[1]) % 4096;
            reference::Camera camera;
            camera.tan_half_fov = 0.1f + unit_of(x[2]);
            const std::uint32_t pixel =
                parity_bits(x[3]) % (parameters.image_width * parameters.image_height);
            put(out, 0,
                reference::primary_ray(camera, parameters, pixel, parity_bits(x[4])).direction);
            break;
        }
        case ParityCase::count:
            break;
    }
    return out;
}

}  // namespace scotty::gpu
