/// What assimp lets pass or reports without saying where: checked in the file itself beforehand.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "scenes/notes.h"

namespace scotty::scenes {

/// The whole file as bytes. Throws reference::Error (bad_input) where it cannot be read.
std::string read_file(const std::string& path);

/// glTF (.gltf or .glb): JSON whose buffers, views, accessors and nodes hang together. Returns the
/// JSON. Notes extensions that are not supported.
nlohmann::json check_gltf(const std::string& path, Notes& notes);

/// How many triangles the plain triangle lists of a checked glTF file announce.
std::uint64_t gltf_triangles(const nlohmann::json& root);

}  // namespace scotty::scenes
