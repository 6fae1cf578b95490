/// What a view says: the JSON of docs/view.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "verify/view/render_loop.h"

namespace scotty::verify {

nlohmann::json camera_json(const reference::Camera& camera);
/// The header of a frame, but for what its encoding adds.
nlohmann::json frame_json(const ShownPicture& picture);
/// What stays for the whole session.
nlohmann::json hello_json(const reference::Scene& scene);
/// What the viewers' controls show. `camera_file`: empty, where the camera is the scene's own.
nlohmann::json state_json(const ViewState& state, const reference::Scene& scene,
                          const std::string& camera_file);
nlohmann::json change_json(const ChangeEffect& effect);
nlohmann::json path_json(const Pick& pixel, const TracedPath& path, const reference::Scene& scene);

/// The scene's specification from another camera: "coil#camera=FILE", or "scene.obj#lights=none"
/// with
/// ",camera=FILE" behind. An own camera that the specification has is replaced.
std::string seen_from(const std::string& specification, const std::string& camera_file);
/// The words of the command that renders the state to `file`, without the program's name.
std::vector<std::string> render_words(const ViewState& state, const std::string& scene,
                                      const std::string& file);
/// Words as a line of a shell.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace scotty::verify
