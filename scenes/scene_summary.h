/// What is in a scene, for `scotty info`.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::scenes {

/// As many as reference::LightKind has.
constexpr std::size_t kLightKinds = static_cast<std::size_t>(reference::LightKind::spot) + 1;

struct SceneSummary {
    std::string name;
    std::string source;
    std::string fingerprint;  ///< of all that influences a picture, in hexadecimal
    reference::FileContents file;
    std::size_t triangles = 0;
    std::size_t empty_triangles = 0;  ///< of zero area: never hit
    std::size_t vertices = 0;
    std::size_t smooth_vertices = 0;         ///< with a normal of their own
    std::array<std::size_t, 3> materials{};  ///< by reference::MaterialKind
    std::size_t emissive_materials = 0;
    std::array<std::size_t, kLightKinds> lights{};  ///< by reference::LightKind
    reference::Camera camera;
    reference::Bounds extents;
    /// The scene's warnings: what the file has and is not shown as it says, and what was repaired,
    /// chosen or added.
    std::vector<std::string> unsupported;
    std::vector<std::string> repaired;
};

SceneSummary summarize(const reference::Scene& scene);

std::string to_text(const SceneSummary& summary);
nlohmann::ordered_json to_json(const SceneSummary& summary);

}  // namespace scotty::scenes
