/// Triangles, rays and scenes that are hard on an intersector: degenerate, huge, tiny, denormal,
/// far from the origin, duplicated, non-manifold.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reference/contract/records.h"
#include "reference/contract/scene.h"
#include "tests/reference/meshes.h"

namespace scotty::reference::test {

struct Box {
    Vec3 low, high;
};

inline Box united(const Box& a, const Box& b) {
    return {min_of(a.low, b.low), max_of(a.high, b.high)};
}

struct Triangle {
    Vec3 v0, v1, v2;
    Box box() const { return {min_of(min_of(v0, v1), v2), max_of(max_of(v0, v1), v2)}; }
};

/// One of the magnitudes that floats of scenes have, and a few that they should not.
inline float random_scale(Random& random) {
    static constexpr std::array<float, 9> kScales{1.0f,    1.0f,     1.0f,   1.0e-3f, 1.0e3f,
                                                  1.0e-9f, 1.0e-30f, 1.0e9f, 3.0e11f};
    return kScales[random() % kScales.size()];
}

/// Random, axis-parallel, with zeros of both signs, denormal or huge components.
inline Vec3 hard_direction(Random& random) {
    Vec3 direction = unit_vector(random);
    for (int axis = 0; axis < 3; ++axis) {
        switch (random() % 10) {
            case 0:
                direction[axis] = 0.0f;
                break;
            case 1:
                direction[axis] = -0.0f;
                break;
            case 2:
                direction[axis] *= 1.0e-41f;
                break;
            case 3:
                direction[axis] *= 1.0e-12f;
                break;
            default:
                break;
        }
    }
    if (is_zero(direction)) direction[static_cast<int>(random() % 3)] = 1.0f;
    if (random() % 16 == 0) direction *= random_scale(random);
    return direction;
}

/// Plain triangles, needles, axis-aligned and zero-area ones.
inline Triangle hard_triangle(Random& random) {
    const float scale = random_scale(random);
    Triangle t{scale * uniform3(random, -1, 1), scale * uniform3(random, -1, 1),
               scale * uniform3(random, -1, 1)};
    switch (random() % 6) {
        case 0:
            t.v2 = 0.5f * (t.v0 + t.v1) + 1.0e-6f * scale * uniform3(random, -1, 1);
            break;
        case 1:
            t.v2 = 0.5f * (t.v0 + t.v1);
            break;
        case 2:
            t.v0.z = t.v1.z = t.v2.z;
            break;
        case 3:
            t.v1 = t.v0 + 1.0e-5f * (t.v1 - t.v0);
            break;
        case 4:
            t.v2 = t.v1;
            break;
        default:
            break;
    }
    return t;
}

/// Aimed at the triangle, its edges, its corners, or along its plane, from near or far.
inline Ray hard_ray(Random& random, const Triangle& triangle) {
    const float x = uniform(random, 0, 1);
    const float y = uniform(random, 0, 1 - x);
    const Vec3 edge_x = triangle.v1 - triangle.v0;
    const Vec3 edge_y = triangle.v2 - triangle.v0;
    std::array<Vec3, 4> targets{triangle.v0 + x * edge_x + y * edge_y, triangle.v0 + x * edge_x,
                                triangle.v0, triangle.v2};
    const Vec3& target = targets[random() % targets.size()];
    const float size = max_abs(triangle.box().high - triangle.box().low);
    Ray ray{target, 0.0f, hard_direction(random), kInfinity};
    switch (random() % 5) {
        case 0:
            break;  // starts on the triangle
        case 1:
            ray.direction = x * edge_x + (y - 0.3f) * edge_y;
            [[fallthrough]];  // edge-on
        case 2:
            ray.origin = target - size * ray.direction;
            break;
        case 3:
            ray.origin = target - 1000.0f * size * ray.direction;
            break;
        default:
            ray.origin = size * uniform3(random, -10, 10);
            ray.direction = target - ray.origin;
            break;
    }
    if (random() % 4 == 0) ray.direction = -ray.direction;
    if (is_zero(ray.direction)) ray.direction = Vec3(0, 1, 0);
    return ray;
}

/// What one scene is mostly made of.
enum class HardScene : std::uint32_t {
    mixed,         ///< all magnitudes and shapes at once
    far_away,      ///< small triangles, a million of their sizes from the origin
    denormal,      ///< coordinates that floats hold with few bits
    duplicated,    ///< each triangle several times, some of them turned over
    non_manifold,  ///< fans of many triangles around one edge, and bow ties that share a corner
    coplanar       ///< overlapping, in few planes
};
constexpr std::uint32_t kHardScenes = 6;

inline Scene hard_scene(HardScene kind, std::size_t triangles, Random& random) {
    Scene scene;
    scene.name = "hard " + std::to_string(static_cast<std::uint32_t>(kind));
    scene.materials.emplace_back();
    const Vec3 place = uniform3(random, -1, 1);
    while (scene.triangles.size() < triangles) {
        Triangle t = hard_triangle(random);
        const Vec3 corner = place + uniform3(random, -1, 1);
        switch (kind) {
            case HardScene::mixed:
                break;
            case HardScene::far_away: {
                const Vec3 at = 1.0e6f * place;
                t = {at + uniform3(random, -1, 1), at + uniform3(random, -1, 1),
                     at + uniform3(random, -1, 1)};
                break;
            }
            case HardScene::denormal:
                t = {1.0e-41f * uniform3(random, -1, 1), 1.0e-41f * uniform3(random, -1, 1),
                     1.0e-41f * uniform3(random, -1, 1)};
                break;
            case HardScene::duplicated:
                if (!scene.triangles.empty() && random() % 4 != 0) {
                    const auto& old = scene.triangles[random() % scene.triangles.size()];
                    t = {scene.vertices[old[0]], scene.vertices[old[1]], scene.vertices[old[2]]};
                    if (random() % 2 == 0) std::swap(t.v1, t.v2);
                }
                break;
            case HardScene::non_manifold:
                for (int i = 0; i < 6; ++i) {
                    add_triangle(scene, corner, place, place + uniform3(random, -1, 1));
                }
                t = {place, corner + uniform3(random, -1, 1), corner};
                break;
            case HardScene::coplanar:
                t = {uniform3(random, -1, 1), uniform3(random, -1, 1), uniform3(random, -1, 1)};
                t.v0.y = t.v1.y = t.v2.y = random() % 2 == 0 ? 0.0f : -0.0f;
                break;
        }
        add_triangle(scene, t.v0, t.v1, t.v2);
    }
    return scene;
}

/// Rays at its triangles, their edges and corners.
inline std::vector<Ray> hard_rays(const Scene& scene, std::size_t count, Random& random) {
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const auto& index = scene.triangles[random() % scene.triangles.size()];
        const Ray ray = hard_ray(
            random, {scene.vertices[index[0]], scene.vertices[index[1]], scene.vertices[index[2]]});
        // What comes from outside is refused by the pipelines where it is not finite.
        const auto finite = [](const Vec3& v) {
            return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
        };
        if (finite(ray.origin) && finite(ray.direction)) rays.push_back(ray);
    }
    return rays;
}

}  // namespace scotty::reference::test
