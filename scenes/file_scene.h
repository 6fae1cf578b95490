/// What all file loaders do after reading: emitters, missing lights, missing cameras.
#pragma once

#include <vector>

#include "reference/contract/scene.h"
#include "scenes/loaders.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// What a surface reflects for which a file names no material, in every format.
constexpr float kDefaultReflectance = 0.5f;
constexpr const char* kDefaultMaterialNote = "a mesh without material: grey 0.5";
/// The index of a new material of that reflectance.
std::uint32_t add_default_material(reference::Scene& scene);

/// Brings emissive triangles and lights together, so that no emission is counted twice.
///
/// A triangle that lies in an area light is that light's visible side: its material's emission is
/// marked as sampled, and its winding is turned to the light's front where it faces away. The other
/// emissive triangles become lights themselves, if there are at most kMaxTriangleLights of them.
void settle_emission(reference::Scene& scene, Notes& notes);

constexpr std::size_t kMaxTriangleLights = 1024;

/// Lights a scene in which nothing shines so that its shapes show: a directional light from above
/// and beside the camera, and a dim environment for what it does not reach. A white surface that
/// faces the light has a radiance of 1. Call it when the camera is settled.
void add_default_lights(reference::Scene& scene, Notes& notes);

/// A camera that sees all of the scene: it looks along `direction_of`'s forward at the middle of
/// the bounding box, from where all of the box is inside a square picture, whatever the scene's
/// size.
reference::Camera fit_camera(const reference::Scene& scene, const reference::Camera& direction_of);

/// Sets scene.camera: the file's own, which is its first, or a fitted one where there is none or
/// `choice` asks for it.
void settle_camera(reference::Scene& scene, const std::vector<Viewpoint>& viewpoints,
                   CameraChoice choice, Notes& notes);

}  // namespace scotty::scenes
