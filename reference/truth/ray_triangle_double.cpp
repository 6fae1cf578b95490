#include "reference/truth/ray_triangle_double.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "reference/numerics/intersect_triangle.h"

namespace scotty::reference {
namespace {

/// Of the farthest vertex's distance: 16 units in the last place, for the sheared vertices of both
/// float tests.
constexpr double kRounding = 1.0 / (1 << 20);

/// Edge functions below this underflow in float, whatever their relative precision.
constexpr double kUnderflow = std::numeric_limits<float>::min();

/// A vertex seen from the ray: x and y across it, z its parameter t along it.
struct Sheared {
    double x, y, t;
    double across() const { return std::sqrt(x * x + y * y); }
};

struct Shear {
    int kx, ky, kz;
    glm::dvec3 origin;
    double dx, dy, dz;

    explicit Shear(const Ray& ray)
        : kx(next_axis(ray_shear(ray.direction).kz)),
          ky(next_axis(kx)),
          kz(ray_shear(ray.direction).kz),
          origin{component(ray.origin, kx), component(ray.origin, ky), component(ray.origin, kz)},
          dx(component(ray.direction, kx)),
          dy(component(ray.direction, ky)),
          dz(component(ray.direction, kz)) {}

    /// From the origin, axes permuted; exact unless the two differ by 29 binary orders.
    glm::dvec3 relative(const Vec3& vertex) const {
        return glm::dvec3{component(vertex, kx), component(vertex, ky), component(vertex, kz)} -
               origin;
    }
    Sheared apply(const glm::dvec3& p) const {
        const double t = p.z / dz;
        return {p.x - dx * t, p.y - dy * t, t};
    }
};

double cross(const Sheared& a, const Sheared& b) { return a.x * b.y - a.y * b.x; }

/// Signed area opposite one vertex, and how far rounding may shift it.
struct Edge {
    double area;
    double area_margin;
    double length;

    Edge(const Sheared& from, const Sheared& to, double length_in_space, double tolerance)
        : area(cross(from, to)),
          area_margin(tolerance * (from.across() + to.across() + length_in_space) + kUnderflow),
          length(Sheared{to.x - from.x, to.y - from.y, 0.0}.across()) {}

    bool surely_negative() const { return area < -area_margin; }
    bool surely_positive() const { return area > area_margin; }
};

}  // namespace

TriangleVerdict judge_triangle(const Scene& scene, std::uint32_t triangle, const Ray& ray) {
    TriangleVerdict out;
    if (is_zero(ray.direction)) return out;
    const Shear shear(ray);
    const auto& index = scene.triangles[triangle];
    const glm::dvec3 a = shear.relative(scene.vertices[index[0]]);
    const glm::dvec3 b = shear.relative(scene.vertices[index[1]]);
    const glm::dvec3 c = shear.relative(scene.vertices[index[2]]);
    const std::array<double, 3> sides{glm::length(c - b), glm::length(a - c), glm::length(b - a)};
    const double reach = std::max({glm::length(a), glm::length(b), glm::length(c)});
    const double tolerance = kRounding * reach;

    const Sheared sa = shear.apply(a);
    const Sheared sb = shear.apply(b);
    const Sheared sc = shear.apply(c);
    // In the order and with the signs of edge_functions(): opposite a, b and c.
    const std::array<Edge, 3> edges{Edge(sc, sb, sides[0], tolerance),
                                    Edge(sa, sc, sides[1], tolerance),
                                    Edge(sb, sa, sides[2], tolerance)};
    const bool any_negative =
        std::any_of(edges.begin(), edges.end(), [](const Edge& e) { return e.surely_negative(); });
    const bool any_positive =
        std::any_of(edges.begin(), edges.end(), [](const Edge& e) { return e.surely_positive(); });
    const bool all_sure = std::all_of(edges.begin(), edges.end(), [](const Edge& e) {
        return e.surely_negative() || e.surely_positive();
    });

    const double determinant = edges[0].area + edges[1].area + edges[2].area;
    const double determinant_margin =
        edges[0].area_margin + edges[1].area_margin + edges[2].area_margin;
    out.edge_on = std::abs(determinant) / determinant_margin;
    const double sign = determinant < 0.0 ? -1.0 : 1.0;
    out.edge_distance = std::numeric_limits<double>::infinity();
    for (const Edge& edge : edges) {
        const double longest = std::max(edge.length, std::numeric_limits<double>::min());
        const double distance = sign * edge.area / longest;
        if (distance < out.edge_distance) {
            out.edge_distance = distance;
            out.edge_margin = edge.area_margin / longest;
        }
    }

    // t: the vertices' along the ray, weighted; edge-on it can be anywhere between them.
    const double first_t = std::min({sa.t, sb.t, sc.t});
    const double last_t = std::max({sa.t, sb.t, sc.t});
    const double speed = std::sqrt(shear.dx * shear.dx + shear.dy * shear.dy + shear.dz * shear.dz);
    const double rounding_t = 2.0 * tolerance / speed;
    const bool edge_on = !(out.edge_on > 1.0);
    if (edge_on) {
        out.t = 0.5 * (first_t + last_t);
        out.t_margin = 0.5 * (last_t - first_t) + rounding_t;
        out.u = out.v = 1.0 / 3.0;
        out.uv_margin = std::numeric_limits<double>::infinity();
    } else {
        out.u = edges[1].area / determinant;
        out.v = edges[2].area / determinant;
        out.t = (edges[0].area * sa.t + edges[1].area * sb.t + edges[2].area * sc.t) / determinant;
        // Rounded edges tilt the plane: by their rounding over the area that the ray sees.
        const double side = std::max({sides[0], sides[1], sides[2]});
        const double least = std::abs(determinant) - determinant_margin;
        const double facing = least * std::abs(shear.dz) / speed;
        const double tilt = side * side / facing;
        out.t_margin = std::min(rounding_t * (1.0 + tilt), (last_t - first_t) + rounding_t);
        out.uv_margin = 2.0 * determinant_margin / least + kRounding;
    }

    const double t_min = ray.t_min;
    const double t_max = ray.t_max;
    const bool beyond = !(out.t + out.t_margin >= t_min && out.t - out.t_margin < t_max);
    const bool sure_of_t = out.t - out.t_margin > t_min && out.t + out.t_margin < t_max;
    if ((any_negative && any_positive) || beyond || !(t_min < t_max)) {
        out.verdict = Verdict::miss;
    } else {
        out.verdict = all_sure && sure_of_t && !edge_on ? Verdict::hit : Verdict::grazing;
    }
    return out;
}

std::string describe(const TriangleVerdict& verdict) {
    static constexpr std::array<const char*, 3> kNames{"must be missed", "may be missed or hit",
                                                       "must be hit"};
    return fmt::format("{}: t {:.9g} +- {:.2g}, {:.3g} {} the nearest edge (margin {:.2g}){}",
                       kNames[static_cast<std::size_t>(verdict.verdict)], verdict.t,
                       verdict.t_margin, std::abs(verdict.edge_distance),
                       verdict.edge_distance < 0.0 ? "outside" : "inside", verdict.edge_margin,
                       verdict.edge_on > 1.0 ? "" : ", edge-on");
}

}  // namespace scotty::reference
