#include <fmt/format.h>

#include <array>
#include <cmath>

#include "reference/base/error.h"
#include "scenes/affine.h"
#include "scenes/built_in.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kCoilRadius = 0.55;
constexpr double kTubeRadius = 0.055;
constexpr double kBottom = 0.12;
constexpr double kTop = 1.45;

/// A closed tube around a helix with a vertical axis: rings of `sides` vertices, a fan at each end.
void add_tube(reference::Scene& scene, double turns, std::uint32_t segments, std::uint32_t sides,
              std::uint32_t material) {
    const auto base = static_cast<std::uint32_t>(scene.vertices.size());
    const double angle = kTwoPi * turns;
    const double rise = kTop - kBottom;
    const double slope = std::sqrt(kCoilRadius * kCoilRadius * angle * angle + rise * rise);
    std::array<Point, 2> ends{};
    std::array<Point, 2> tangents{};
    for (std::uint32_t s = 0; s <= segments; ++s) {
        const double t = static_cast<double>(s) / segments;
        const double c = std::cos(angle * t);
        const double n = std::sin(angle * t);
        const Point centre = {kCoilRadius * c, kBottom + rise * t, kCoilRadius * n};
        const Point tangent = {-kCoilRadius * angle * n / slope, rise / slope,
                               kCoilRadius * angle * c / slope};
        // Frame of the ring: outwards from the axis, and across.
        const Point outward = {c, 0.0, n};
        const Point across = {tangent[1] * outward[2] - tangent[2] * outward[1],
                              tangent[2] * outward[0] - tangent[0] * outward[2],
                              tangent[0] * outward[1] - tangent[1] * outward[0]};
        for (std::uint32_t k = 0; k < sides; ++k) {
            const double a = kTwoPi * k / sides;
            Point normal{};
            Point position{};
            for (std::size_t i = 0; i < 3; ++i) {
                normal[i] = std::cos(a) * outward[i] + std::sin(a) * across[i];
                position[i] = centre[i] + kTubeRadius * normal[i];
            }
            add_vertex(scene, rounded(position), rounded(normal));
        }
        if (s == 0 || s == segments) {
            ends[s == 0 ? 0 : 1] = centre;
            tangents[s == 0 ? 0 : 1] = tangent;
        }
    }
    for (std::uint32_t s = 0; s < segments; ++s) {
        for (std::uint32_t k = 0; k < sides; ++k) {
            const std::uint32_t next = (k + 1) % sides;
            const std::uint32_t low = base + s * sides;
            const std::uint32_t high = low + sides;
            add_triangle(scene, low + k, low + next, high + next, material);
            add_triangle(scene, low + k, high + next, high + k, material);
        }
    }
    // The caps share the ring's vertices, so that the tube is closed.
    const Vec3 tangent = rounded(tangents[0]);
    const std::uint32_t first = add_vertex(scene, rounded(ends[0]), -tangent);
    const std::uint32_t last = add_vertex(scene, rounded(ends[1]), rounded(tangents[1]));
    const std::uint32_t top = base + segments * sides;
    for (std::uint32_t k = 0; k < sides; ++k) {
        const std::uint32_t next = (k + 1) % sides;
        add_triangle(scene, first, base + next, base + k, material);
        add_triangle(scene, last, top + k, top + next, material);
    }
}

reference::Scene generate_coil(const Parameters& parameters) {
    const double segments = parameters.number("segments");
    const double sides = parameters.number("sides");
    const double triangles = 2.0 * (segments + 1.0) * sides;
    if (triangles > kMaxTriangles) {
        throw reference::Error::bad_input(
            "scene coil", fmt::format("segments={} and sides={} make {:.0f} triangles; at most "
                                      "{:.0f} are made",
                                      segments, sides, triangles, kMaxTriangles));
    }
    reference::Scene scene = cornell_room();
    const std::uint32_t metal = add_mirror(scene, Vec3(0.42f, 0.36f, 0.27f));
    add_tube(scene, parameters.number("turns"), parameters.integer("segments"),
             parameters.integer("sides"), metal);
    return scene;
}

}  // namespace

const Generator kCoil = {
    "coil",
    "Cornell box with a coil of dim mirror: long, thin, curved, many nodes entered in vain",
    {{"turns", 8, 0.25, 1000, false}, {"segments", 328, 3, 1e8}, {"sides", 12, 3, 1e6}},
    generate_coil};

}  // namespace scotty::scenes
