#include "scenes/add_polygon.h"

#include "scenes/mesh.h"
#include "scenes/triangulate_polygon.h"

namespace scotty::scenes {

void PolygonAdder::add(std::span<const std::uint32_t> vertices, std::uint32_t material) {
    if (vertices.size() == 3) {
        add_triangle(scene_, vertices[0], vertices[1], vertices[2], material);
        return;
    }
    corners_.clear();
    for (const std::uint32_t vertex : vertices) {
        if (corners_.empty() || corners_.back() != vertex) corners_.push_back(vertex);
    }
    while (corners_.size() > 1 && corners_.front() == corners_.back()) corners_.pop_back();
    // Too few are left of a face without an area: the scene's checks report its first triangle.
    if (corners_.size() < 3) corners_.assign(vertices.begin(), vertices.begin() + 3);
    points_.clear();
    for (const std::uint32_t corner : corners_) {
        points_.push_back(widened(scene_.vertices[corner]));
    }
    triangles_.clear();
    if (!triangulate_polygon(points_, triangles_)) {
        notes_.add("a polygon that crosses itself: cut into triangles that may overlap");
    }
    for (const auto& [a, b, c] : triangles_) {
        add_triangle(scene_, corners_[a], corners_[b], corners_[c], material);
    }
}

}  // namespace scotty::scenes
