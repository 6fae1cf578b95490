/// Geodesic spheres: each face of an icosahedron as a grid of frequency^2 triangles.
///
/// Watertight by construction: a vertex on an edge exists once and is shared by index, found by
/// arithmetic, so that millions of triangles need no map.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "reference/contract/scene.h"

namespace scotty::scenes {

/// A direction in double precision, unit length.
using Direction = std::array<double, 3>;

constexpr std::uint64_t geodesic_triangles(std::uint64_t frequency) {
    return 20 * frequency * frequency;
}
constexpr std::uint64_t geodesic_vertices(std::uint64_t frequency) {
    return 10 * frequency * frequency + 2;
}
/// Smallest frequency with at least `triangles` triangles.
std::uint32_t geodesic_frequency(double triangles);

/// Adds a geodesic sphere, fronts outside; `position_of` places each unit direction.
/// Normals are left zero.
void add_geodesic(reference::Scene& scene, std::uint32_t frequency, std::uint32_t material,
                  const std::function<reference::Vec3(const Direction&)>& position_of);

/// Adds a sphere with exact smooth normals.
void add_sphere(reference::Scene& scene, const reference::Vec3& centre, float radius,
                std::uint32_t frequency, std::uint32_t material);

}  // namespace scotty::scenes
