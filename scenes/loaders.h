/// Scenes from files. Each loader reads one file; load_scene() adds default lights
/// and validates.
#pragma once

#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "scenes/viewpoints.h"

namespace scotty::scenes {

/// Where the camera of a loaded scene comes from: the file's own, or one that frames everything.
enum class CameraChoice {
    automatic,  ///< fit where the file is made for Scotty3D, which frames its scenes itself; else
                ///< file
    file,
    fit
};

/// What the end of a specification says: "scene.dae#camera=fit,lights=none".
struct FileChoices {
    CameraChoice camera = CameraChoice::automatic;
    std::string viewpoint;       ///< the name of one of the file's cameras; empty: not chosen
    bool default_lights = true;  ///< whether a scene in which nothing shines is lit
};

/// Takes the choices off the end of a path. Throws reference::Error (bad_input) for unknown ones.
FileChoices take_choices(std::string& path);

/// COLLADA with the Scotty3D extras. Throws reference::Error (bad_input) naming file and element.
reference::Scene load_collada(const std::string& path, CameraChoice camera,
                              std::vector<Viewpoint>& viewpoints);

/// OBJ with its material libraries. Throws reference::Error (bad_input) naming file and line.
reference::Scene load_obj(const std::string& path, CameraChoice camera);

/// PLY, as text or binary. Throws reference::Error (bad_input) naming file, element and number.
reference::Scene load_ply(const std::string& path, CameraChoice camera);

/// glTF 2.0 (.gltf, .glb). Throws reference::Error (bad_input) naming file and element.
reference::Scene load_gltf(const std::string& path, CameraChoice camera,
                           std::vector<Viewpoint>& viewpoints);

}  // namespace scotty::scenes
