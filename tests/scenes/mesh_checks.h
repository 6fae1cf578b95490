/// What the tests of scenes ask of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "reference/contract/scene.h"

namespace scotty::tests {

using reference::Scene;
using reference::Vec3;

/// Triangles of one material.
inline std::size_t count_of_material(const Scene& scene, std::uint32_t material) {
    std::size_t count = 0;
    for (const std::uint32_t m : scene.material_of) count += m == material ? 1u : 0u;
    return count;
}

/// Number of directed edges (by vertex index) of `material`'s triangles whose opposite is not
/// there exactly once: 0 for a closed, consistently wound surface.
inline std::size_t open_edges(const Scene& scene, std::uint32_t material) {
    std::map<std::array<std::uint32_t, 2>, int> edges;
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        if (scene.material_of[i] != material) continue;
        const auto& t = scene.triangles[i];
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    std::size_t open = 0;
    for (const auto& [edge, count] : edges) {
        const auto opposite = edges.find({edge[1], edge[0]});
        if (count != 1 || opposite == edges.end() || opposite->second != 1) ++open;
    }
    return open;
}

/// Six times the volume that `material`'s triangles enclose: positive where fronts are outside.
inline double signed_volume(const Scene& scene, std::uint32_t material) {
    double volume = 0.0;
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        if (scene.material_of[i] != material) continue;
        const auto& [a, b, c] = scene.triangles[i];
        volume += reference::dot(scene.vertices[a],
                                 reference::cross(scene.vertices[b], scene.vertices[c]));
    }
    return volume;
}

/// Of all triangles together.
inline double area_of(const Scene& scene) {
    double doubled = 0.0;
    for (const auto& [a, b, c] : scene.triangles) {
        doubled += reference::length(reference::cross(scene.vertices[b] - scene.vertices[a],
                                                      scene.vertices[c] - scene.vertices[a]));
    }
    return 0.5 * doubled;
}

/// Largest deviation from unit length of the non-zero normals.
inline float worst_normal(const Scene& scene) {
    float worst = 0.0f;
    for (const Vec3& n : scene.normals) {
        if (reference::is_zero(n)) continue;
        worst = std::max(worst, reference::abs_of(reference::length(n) - 1.0f));
    }
    return worst;
}

inline Vec3 front_of(const Scene& scene, std::size_t triangle) {
    const auto& [a, b, c] = scene.triangles[triangle];
    return reference::normalize_or(reference::cross(scene.vertices[b] - scene.vertices[a],
                                                    scene.vertices[c] - scene.vertices[a]),
                                   Vec3(0.0f, 0.0f, 0.0f));
}

/// Whether one of the scene's warnings contains `text`.
inline bool warns(const Scene& scene, const std::string& text) {
    for (const std::string& warning : scene.warnings) {
        if (warning.find(text) != std::string::npos) return true;
    }
    return false;
}

inline std::string all_warnings(const Scene& scene) {
    std::string text;
    for (const std::string& warning : scene.warnings) text += warning + "\n";
    return text;
}

}  // namespace scotty::tests
