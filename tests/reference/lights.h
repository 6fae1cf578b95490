/// Lights, and what they send to a surface: estimated, and in closed form.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "reference/numerics/light_sampling.h"

namespace scotty::reference::test {

inline Light area_light(LightKind kind, const Vec3& corner, const Vec3& x, const Vec3& y,
                        float radiance) {
    Light light;
    light.kind = kind;
    light.position = corner;
    light.edge_x = x;
    light.edge_y = y;
    light.normal = normalize_or(cross(x, y), Vec3(0, 0, 1));
    light.area = length(cross(x, y)) * (kind == LightKind::triangle ? 0.5f : 1.0f);
    light.radiance = Vec3(radiance);
    return light;
}

inline Surface surface_of(const Vec3& position, const Vec3& normal) {
    Surface surface{};
    surface.position = position;
    surface.geometric_normal = normal;
    surface.shading_normal = normal;
    surface.front = true;
    return surface;
}

struct Estimate {
    double mean;
    double error;  ///< standard deviation of the mean
};

/// Irradiance at a surface by `count` samples that `sample` takes for a light, surface, u and v.
template <class Sample>
Estimate irradiance(const Light& light, const Surface& surface, std::uint32_t count,
                    const Sample& sample) {
    double sum = 0.0;
    double squares = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Random4 r = random4(5, i, 0, 0, 0);
        const LightSample s = sample(light, surface, r.b, r.c);
        const double cosine = std::max(0.0f, dot(s.direction, surface.shading_normal));
        const double value = cosine * s.irradiance.x;
        sum += value;
        squares += value * value;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

inline Estimate irradiance(const Light& light, const Surface& surface, std::uint32_t count) {
    return irradiance(light, surface, count, sample_light);
}

/// Lambert's formula (1760): irradiance from a polygon of radiance 1 that is wholly above the
/// horizon, counter-clockwise as the light's front shows it, so clockwise as the point sees it.
inline double lambert(const std::vector<Vec3>& polygon, const Vec3& from, const Vec3& normal) {
    using Double3 = std::array<double, 3>;
    const auto towards = [&](const Vec3& v) {
        Double3 d{double{v.x} - from.x, double{v.y} - from.y, double{v.z} - from.z};
        const double norm = std::hypot(d[0], d[1], d[2]);
        for (double& c : d) c /= norm;
        return d;
    };
    double sum = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Double3 a = towards(polygon[i]);
        const Double3 b = towards(polygon[(i + 1) % polygon.size()]);
        const Double3 n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                        a[0] * b[1] - a[1] * b[0]};
        const double sine = std::hypot(n[0], n[1], n[2]);
        const double angle = std::atan2(sine, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        if (sine == 0.0) continue;
        sum -= angle * (n[0] * normal.x + n[1] * normal.y + n[2] * normal.z) / sine;
    }
    return 0.5 * sum;
}

}  // namespace scotty::reference::test
