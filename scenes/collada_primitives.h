/// The inside of a <mesh>: its sources, and its primitives as polygons.
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/affine.h"
#include "scenes/collada_document.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// Where the corners of one primitives element (<triangles>, <polylist>, ...) come from.
struct CornerInputs {
    std::vector<Point> positions;
    std::vector<Point> normals;
    bool has_normals = false;
    std::uint32_t position_offset = 0;
    std::uint32_t normal_offset = 0;
    std::uint32_t stride = 0;  ///< indices for each corner
};

CornerInputs read_inputs(const ColladaDocument& document, pugi::xml_node primitives, Notes& notes);

/// Polygons as rings of corners: an outline each, followed by its holes.
struct Polygons {
    std::vector<std::uint32_t> ring_counts;  ///< rings of each polygon; empty: one each
    std::vector<std::uint32_t> ring_sizes;   ///< corners of each ring
    std::vector<std::uint32_t> corners;      ///< CornerInputs::stride indices for each corner
};

/// Whether an element of a <mesh> holds polygons: <triangles>, <tristrips>, <trifans>, <polylist>
/// or <polygons>.
bool holds_polygons(const char* name);

/// Reads what holds_polygons(); strips and fans come out as triangles.
Polygons read_polygons(const ColladaDocument& document, pugi::xml_node primitives,
                       std::uint32_t stride, Notes& notes);

}  // namespace scotty::scenes
