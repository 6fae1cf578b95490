/// What a PLY file says about itself: format, elements, their properties (G. Turk, "The PLY Polygon
/// File Format", 1994).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/file_reader.h"

namespace scotty::scenes {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    std::optional<PlyType> count_type;  ///< of a list; none: a single value
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    /// The number of single values, or of lists, of this name.
    std::size_t values_named(const std::string& wanted) const;
    /// Null where there is none of the name, or where it is a list.
    const PlyProperty* value(const std::string& wanted) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    bool names_texture = false;  ///< in a comment "TextureFile", as MeshLab writes it

    /// Null where there is none.
    const PlyElement* element(const std::string& name) const;
};

/// Leaves the reader at the first byte of data, whatever that is. Strict: throws reference::Error
/// (bad_input) with the line that it does not understand.
PlyHeader read_ply_header(FileReader& reader);

}  // namespace scotty::scenes
