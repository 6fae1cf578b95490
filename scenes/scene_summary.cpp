#include "scenes/scene_summary.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace scotty::scenes {

using reference::Camera;
using reference::Vec3;

namespace {

constexpr std::array kMaterialNames = {"diffuse", "mirror", "glass"};
constexpr std::array kLightNames = {"parallelogram", "triangle",   "point", "directional",
                                    "environment",   "hemisphere", "spot"};
static_assert(kLightNames.size() == kLightKinds);

/// The words that loaders use for what a picture lacks.
bool says_unsupported(const std::string& warning) {
    for (const char* words : {"not supported", "left out", "approximated"}) {
        if (warning.find(words) != std::string::npos) return true;
    }
    return false;
}

bool is_empty(const reference::Scene& scene, const std::array<std::uint32_t, 3>& triangle) {
    const auto& [a, b, c] = triangle;
    return reference::is_zero(reference::cross(scene.vertices[b] - scene.vertices[a],
                                               scene.vertices[c] - scene.vertices[a]));
}

double degrees(float tangent_of_half) {
    return 2.0 * std::atan(static_cast<double>(tangent_of_half)) * 180.0 / 3.14159265358979323846;
}

std::string vector_text(const Vec3& v) { return fmt::format("({:g}, {:g}, {:g})", v.x, v.y, v.z); }

nlohmann::ordered_json vector_json(const Vec3& v) { return {v.x, v.y, v.z}; }

std::string camera_text(const Camera& camera) {
    const bool by_width = camera.tan_half_width > 0.0f;
    return fmt::format("at {}, towards {}, {:.4g} degrees {}", vector_text(camera.position),
                       vector_text(camera.forward),
                       degrees(by_width ? camera.tan_half_width : camera.tan_half_fov),
                       by_width ? "wide" : "high");
}

/// "3 diffuse, 1 glass", or "none".
template <std::size_t N>
std::string counts_text(const std::array<std::size_t, N>& counts,
                        const std::array<const char*, N>& names) {
    std::string text;
    for (std::size_t i = 0; i < N; ++i) {
        if (counts[i] == 0) continue;
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[i], names[i]);
    }
    return text.empty() ? "none" : text;
}

template <std::size_t N>
nlohmann::ordered_json counts_json(const std::array<std::size_t, N>& counts,
                                   const std::array<const char*, N>& names) {
    nlohmann::ordered_json json;
    for (std::size_t i = 0; i < N; ++i) json[names[i]] = counts[i];
    return json;
}

std::string list_text(const char* title, const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) {
        text += fmt::format("{:<14} {}\n", text.empty() ? title : "", line);
    }
    return text;
}

}  // namespace

SceneSummary summarize(const reference::Scene& scene) {
    SceneSummary summary;
    summary.name = scene.name;
    summary.source = scene.source;
    summary.fingerprint = fmt::format("{:016x}", reference::fingerprint(scene));
    summary.file = scene.file;
    summary.triangles = scene.triangles.size();
    for (const auto& triangle : scene.triangles) {
        summary.empty_triangles += is_empty(scene, triangle) ? 1u : 0u;
    }
    summary.vertices = scene.vertices.size();
    for (const Vec3& normal : scene.normals) {
        summary.smooth_vertices += reference::is_zero(normal) ? 0u : 1u;
    }
    for (const auto& material : scene.materials) {
        ++summary.materials.at(static_cast<std::size_t>(material.kind));
        summary.emissive_materials += reference::is_zero(material.emission) ? 0u : 1u;
    }
    for (const auto& light : scene.lights) {
        ++summary.lights.at(static_cast<std::size_t>(light.kind));
    }
    summary.camera = scene.camera;
    summary.extents = reference::bounds_of(scene);
    for (const std::string& warning : scene.warnings) {
        (says_unsupported(warning) ? summary.unsupported : summary.repaired).push_back(warning);
    }
    return summary;
}

std::string to_text(const SceneSummary& summary) {
    const Vec3 size = summary.extents.high - summary.extents.low;
    std::string text = fmt::format("{:<14} {}\n", "scene", summary.source);
    if (summary.file.meshes != 0) {
        text += fmt::format("{:<14} {}, placed {} times\n", "meshes", summary.file.meshes,
                            summary.file.instances);
    }
    text += fmt::format("{:<14} {}{}\n", "triangles", summary.triangles,
                        summary.empty_triangles == 0
                            ? ""
                            : fmt::format(", {} of zero area", summary.empty_triangles));
    text += fmt::format("{:<14} {}, {} with a normal\n", "vertices", summary.vertices,
                        summary.smooth_vertices);
    text +=
        fmt::format("{:<14} {}{}\n", "materials", counts_text(summary.materials, kMaterialNames),
                    summary.emissive_materials == 0
                        ? ""
                        : fmt::format("; {} of them shine", summary.emissive_materials));
    text += fmt::format("{:<14} {}\n", "lights", counts_text(summary.lights, kLightNames));
    text += fmt::format(
        "{:<14} {}{}\n", "camera", camera_text(summary.camera),
        summary.file.meshes == 0 ? "" : fmt::format("; {} in the file", summary.file.cameras));
    text += fmt::format("{:<14} {} to {}, {:g} x {:g} x {:g} m\n", "extents",
                        vector_text(summary.extents.low), vector_text(summary.extents.high), size.x,
                        size.y, size.z);
    text += fmt::format("{:<14} {}\n", "fingerprint", summary.fingerprint);
    text += list_text("not supported", summary.unsupported);
    return text + list_text("repaired", summary.repaired);
}

nlohmann::ordered_json to_json(const SceneSummary& summary) {
    const Camera& camera = summary.camera;
    nlohmann::ordered_json json{{"name", summary.name},
                                {"source", summary.source},
                                {"fingerprint", summary.fingerprint},
                                {"triangles", summary.triangles},
                                {"empty_triangles", summary.empty_triangles},
                                {"vertices", summary.vertices},
                                {"smooth_vertices", summary.smooth_vertices},
                                {"materials", counts_json(summary.materials, kMaterialNames)},
                                {"emissive_materials", summary.emissive_materials},
                                {"lights", counts_json(summary.lights, kLightNames)}};
    const bool by_width = camera.tan_half_width > 0.0f;
    json["camera"] = {{"position", vector_json(camera.position)},
                      {"forward", vector_json(camera.forward)},
                      {"up", vector_json(camera.up)},
                      {by_width ? "horizontal_degrees" : "vertical_degrees",
                       degrees(by_width ? camera.tan_half_width : camera.tan_half_fov)}};
    if (summary.file.meshes != 0) {
        json["file"] = {{"meshes", summary.file.meshes},
                        {"instances", summary.file.instances},
                        {"cameras", summary.file.cameras},
                        {"lights", summary.file.lights}};
    }
    json["extents"] = {{"low", vector_json(summary.extents.low)},
                       {"high", vector_json(summary.extents.high)}};
    json["not_supported"] = summary.unsupported;
    json["repaired"] = summary.repaired;
    return json;
}

}  // namespace scotty::scenes
