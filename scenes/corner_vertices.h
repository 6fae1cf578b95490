/// Vertices for the corners of faces whose positions and normals are numbered apart.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::scenes {

/// Gives each pair of a position and a normal one vertex. The first normal of a position becomes
/// that of its own vertex; for every other one a copy of the position is appended to the scene.
/// Normals are compared by their bits, positions by number: neighbours stay watertight.
class CornerVertices {
 public:
    /// `scene` holds the positions as its vertices, with a zero normal each.
    explicit CornerVertices(reference::Scene& scene);

    /// The vertex of a corner; a zero normal means flat.
    std::uint32_t vertex(std::uint32_t position, const reference::Vec3& normal);

    /// Drops the vertices that no corner used.
    void drop_unused();

 private:
    std::size_t first_slot(std::uint32_t position, const reference::Vec3& normal) const;
    void grow();

    reference::Scene& scene_;
    std::vector<bool> is_used_;
    std::uint32_t positions_;
    std::vector<std::uint32_t> position_of_copy_;
    /// Open addressing over the copies; reference::kNone is a free slot.
    std::vector<std::uint32_t> slots_;
};

/// Drops the vertices that `is_used` says are not used and renumbers the triangles' corners.
void drop_unused_vertices(reference::Scene& scene, const std::vector<bool>& is_used);

}  // namespace scotty::scenes
