/// Where scenes come from: built-in generators and files, by one name.
#pragma once

#include <string>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::scenes {

/// One built-in scene, for `scotty list` and the default set of `scotty verify`.
struct BuiltIn {
    std::string name;        ///< "coil"
    std::string parameters;  ///< "turns=8,segments=...", empty where there are none
    std::string description;
};

/// All built-in scenes, in the order they are listed and verified.
const std::vector<BuiltIn>& built_in_scenes();

/// Loads a scene by specification: a built-in's name, optionally with parameters
/// ("blob:triangles=1000000"), or the path of a .dae, .obj, .ply, .gltf or .glb file. Both may end
/// in "#camera=FILE.camera": seen from a camera that `scotty view` has saved (camera_file.h).
/// The result has been through reference::validate_and_repair().
/// Throws reference::Error (bad_input) naming file and element, or the names that do exist.
reference::Scene load_scene(const std::string& specification);

}  // namespace scotty::scenes
