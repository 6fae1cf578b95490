/// Small meshes and random rays for the tests of reference/, made here so that these tests depend
/// on no scene.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::reference::test {

using Random = std::mt19937;

inline float uniform(Random& random, float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random);
}
inline Vec3 uniform3(Random& random, float low, float high) {
    const float x = uniform(random, low, high);
    const float y = uniform(random, low, high);
    return {x, y, uniform(random, low, high)};
}
inline Vec3 unit_vector(Random& random) {
    return normalize_or(uniform3(random, -1.0f, 1.0f), Vec3(0.0f, 0.0f, 1.0f));
}

inline void add_triangle(Scene& scene, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(scene.vertices.size());
    scene.vertices.insert(scene.vertices.end(), {a, b, c});
    scene.triangles.push_back({first, first + 1, first + 2});
    scene.material_of.push_back(0);
}

inline Scene triangle_scene(const Vec3& a, const Vec3& b, const Vec3& c) {
    Scene scene;
    scene.name = "one triangle";
    scene.materials.emplace_back();
    add_triangle(scene, a, b, c);
    return scene;
}

/// `count` triangles of about `size`, centres in the cube from -1 to 1.
inline Scene soup(std::size_t count, float size, std::uint32_t seed) {
    Random random(seed);
    Scene scene;
    scene.name = "soup";
    scene.materials.emplace_back();
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 centre = uniform3(random, -1.0f, 1.0f);
        const Vec3 a = centre + uniform3(random, -size, size);
        const Vec3 b = centre + uniform3(random, -size, size);
        add_triangle(scene, a, b, centre + uniform3(random, -size, size));
    }
    return scene;
}

/// A closed mesh: an icosahedron, each triangle split in four `subdivisions` times, on a sphere.
inline Scene icosphere(int subdivisions, float radius = 1.0f, const Vec3& centre = Vec3(0.0f)) {
    const float g = 1.6180339887f;
    std::vector<Vec3> vertices{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                               {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                               {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    std::vector<std::array<std::uint32_t, 3>> triangles{
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int step = 0; step < subdivisions; ++step) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [place, is_new] =
                middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
            if (is_new) vertices.push_back(0.5f * (vertices[a] + vertices[b]));
            return place->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b);
            const std::uint32_t bc = middle(b, c);
            const std::uint32_t ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    Scene scene;
    scene.name = "icosphere";
    scene.materials.emplace_back();
    for (const Vec3& v : vertices) {
        scene.vertices.push_back(centre + radius * normalize_or(v, Vec3(1.0f, 0.0f, 0.0f)));
    }
    scene.triangles = std::move(triangles);
    scene.material_of.assign(scene.triangles.size(), 0);
    return scene;
}

/// A wavy height field of 2 n^2 triangles.
inline Scene height_field(std::uint32_t n) {
    Scene scene;
    scene.name = "height field";
    scene.materials.emplace_back();
    for (std::uint32_t y = 0; y <= n; ++y) {
        for (std::uint32_t x = 0; x <= n; ++x) {
            const float fx = static_cast<float>(x) / static_cast<float>(n);
            const float fy = static_cast<float>(y) / static_cast<float>(n);
            scene.vertices.emplace_back(fx, fy, 0.1f * std::sin(20.0f * fx) * std::cos(15.0f * fy));
        }
    }
    for (std::uint32_t y = 0; y < n; ++y) {
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t i = y * (n + 1) + x;
            scene.triangles.push_back({i, i + 1, i + n + 1});
            scene.triangles.push_back({i + 1, i + n + 2, i + n + 1});
        }
    }
    scene.material_of.assign(scene.triangles.size(), 0);
    return scene;
}

/// From points in the cube of half size `extent` in random directions, all with hits from 0 on.
inline std::vector<Ray> random_rays(std::size_t count, float extent, std::uint32_t seed) {
    Random random(seed);
    std::vector<Ray> rays;
    rays.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 origin = uniform3(random, -extent, extent);
        rays.push_back({origin, 0.0f, unit_vector(random), kInfinity});
    }
    return rays;
}

}  // namespace scotty::reference::test
