/// A camera in a file of its own, for any scene: "coil#camera=mine.camera".
#pragma once

#include <optional>
#include <string>

#include "reference/contract/records.h"

namespace scotty::scenes {

/// The camera as JSON: position, right, up and forward, tan_half_fov and, where it is not 0,
/// tan_half_width, as reference::Camera has them. Reading gives the same bits.
std::string camera_text(const reference::Camera& camera);

/// Throws reference::Error (bad_input) naming file and member.
reference::Camera read_camera_file(const std::string& path);

/// Takes "camera=FILE.camera" off the choices at the end of a specification.
std::optional<std::string> take_camera_file(std::string& specification);

}  // namespace scotty::scenes
