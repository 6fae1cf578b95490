/// Scenes from files. Each loader reads one file and leaves validation to load_scene().
#pragma once

#include <string>

#include "reference/contract/scene.h"

namespace scotty::scenes {

/// Where the camera of a loaded scene comes from: the file's own, or one that frames everything.
enum class CameraChoice {
    automatic,  ///< fit where the file is made for Scotty3D, which frames its scenes itself; else
                ///< file
    file,
    fit
};

/// COLLADA with the Scotty3D extras. Throws reference::Error (bad_input) naming file and element.
reference::Scene load_collada(const std::string& path, CameraChoice camera);

/// OBJ, PLY, glTF (.gltf, .glb) through assimp. Throws reference::Error (bad_input).
reference::Scene load_with_assimp(const std::string& path, CameraChoice camera);

}  // namespace scotty::scenes
