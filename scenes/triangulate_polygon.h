/// Polygons as triangles: convex or not, flat or slightly bent, with holes or without.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/affine.h"

namespace scotty::scenes {

/// Appends the n - 2 triangles of a polygon of n corners, as corner numbers with the polygon's
/// winding. Where a fan around the first corner is a valid triangulation, as it is for every convex
/// polygon, the fan is taken; else ears are clipped in the projection along the dominant axis of
/// the polygon's normal (D. Eberly, "Triangulation by ear clipping"). No corner is added or left
/// out, so neighbours stay watertight; triangles of zero area occur where corners are collinear.
///
/// Returns false where the polygon crosses itself: no triangulation is right then, and what is
/// appended covers it somehow. Fewer than 3 corners give nothing.
bool triangulate_polygon(std::span<const Point> corners,
                         std::vector<std::array<std::uint32_t, 3>>& triangles);

/// The same for a polygon whose holes are cut out. `ring_sizes` holds the number of corners of the
/// outline and then of each hole, `corners` all of them in this order; the holes may be wound
/// either way. n corners in r rings give n + 2 r - 4 triangles. Returns false, too, where a hole is
/// not inside, or where there are more than 4096 corners and the holes are filled.
bool triangulate_polygon(std::span<const Point> corners, std::span<const std::uint32_t> ring_sizes,
                         std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace scotty::scenes
