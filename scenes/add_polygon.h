/// Faces of mesh files, as triangles of the scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reference/contract/scene.h"
#include "scenes/affine.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// Keeps what cutting a polygon needs, so that millions of faces do not allocate it anew.
class PolygonAdder {
 public:
    PolygonAdder(reference::Scene& scene, Notes& notes) : scene_(scene), notes_(notes) {}

    /// Adds a face of at least three vertices, counter-clockwise seen from the front; concave ones
    /// are cut properly. A vertex that a polygon repeats right away counts once. Notes polygons
    /// that cross themselves.
    void add(std::span<const std::uint32_t> vertices, std::uint32_t material);

 private:
    reference::Scene& scene_;
    Notes& notes_;
    std::vector<std::uint32_t> corners_;
    std::vector<Point> points_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace scotty::scenes
