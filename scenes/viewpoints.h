/// The cameras of a file that has several: "scene.dae#camera=Side" looks from one of them.
#pragma once

#include <string>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::scenes {

struct Viewpoint {
    std::string name;  ///< as a specification takes it, after "#camera="
    reference::Camera camera;
};

/// Adds a camera under a name that no other has and that a specification can hold: commas and
/// number signs become underscores, a second "Side" is "Side 2", and one without a name is "camera"
/// with its number. A file's first 256 are kept.
void add_viewpoint(std::vector<Viewpoint>& viewpoints, const std::string& name,
                   const reference::Camera& camera);

/// "Side, Top and 3 more"
std::string names_of(const std::vector<Viewpoint>& viewpoints);

/// load_scene() of scenes.h, and the cameras of the file, as they are in it; none where it has
/// none, nor for a built-in scene.
reference::Scene load_scene(const std::string& specification, std::vector<Viewpoint>& viewpoints);

}  // namespace scotty::scenes
