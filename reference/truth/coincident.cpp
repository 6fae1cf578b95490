#include "reference/truth/coincident.h"

#include <algorithm>
#include <array>
#include <utility>

#include "reference/numerics/intersect_triangle.h"

namespace scotty::reference {

CoincidentTriangles::CoincidentTriangles(const Scene& scene) : scene_(scene) {
    using Corner = std::array<float, 3>;
    using Place = std::array<Corner, 3>;
    std::vector<std::pair<Place, std::uint32_t>> triangles(scene.triangles.size());
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        auto& [corners, triangle] = triangles[i];
        triangle = i;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& v = scene.vertices[scene.triangles[i][k]];
            corners[k] = {v.x, v.y, v.z};
        }
        std::sort(corners.begin(), corners.end());
    }
    std::sort(triangles.begin(), triangles.end());
    places_.resize(triangles.size());
    for (std::size_t begin = 0, end = 0; begin < triangles.size(); begin = end) {
        while (end < triangles.size() && triangles[end].first == triangles[begin].first) ++end;
        if (end - begin == 1) continue;
        std::vector<std::uint32_t> together;
        for (std::size_t i = begin; i < end; ++i) together.push_back(triangles[i].second);
        for (const std::uint32_t triangle : together) places_[triangle] = together;
    }
}

Hit CoincidentTriangles::seen(const Ray& ray, const Hit& hit) const {
    if (!is_hit(hit)) return hit;
    Hit best = hit;
    bool found = false;
    for (const std::uint32_t triangle : places_[hit.primitive]) {
        const auto& corner = scene_.triangles[triangle];
        Hit candidate{0.0f, triangle, 0.0f, 0.0f};
        if (!intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                                scene_.vertices[corner[0]], scene_.vertices[corner[1]],
                                scene_.vertices[corner[2]], candidate)) {
            continue;
        }
        if (found && !closer(candidate.t, triangle, best.t, best.primitive)) continue;
        best = candidate;
        found = true;
    }
    return best;
}

}  // namespace scotty::reference
