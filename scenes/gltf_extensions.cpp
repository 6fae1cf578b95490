#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "scenes/file_reader.h"
#include "scenes/gltf_document.h"

namespace scotty::scenes {

namespace {

template <std::size_t N>
bool contains(const std::array<const char*, N>& names, const std::string& name) {
    return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
}

/// Read, or approximated with a note where something uses them.
constexpr std::array<const char*, 9> kSupported = {
    "KHR_lights_punctual",    "KHR_materials_emissive_strength",
    "KHR_materials_ior",      "KHR_materials_transmission",
    "KHR_materials_unlit",    "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization",  "KHR_draco_mesh_compression",
    "EXT_meshopt_compression"};

/// About textures, of which none is supported and each is noted.
constexpr std::array<const char*, 4> kAboutTextures = {
    "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif"};

/// Change nothing in a picture of the scene at rest.
constexpr std::array<const char*, 5> kHarmless = {"KHR_xmp", "KHR_xmp_json_ld",
                                                  "KHR_animation_pointer", "FB_ngon_encoding",
                                                  "EXT_structural_metadata"};

/// Extensions that are named in warnings before the rest is only counted.
constexpr std::size_t kMaxExtensionsNamed = 16;

bool may_be_required(const std::string& name) {
    return contains(kSupported, name) || contains(kAboutTextures, name) ||
           contains(kHarmless, name);
}

/// The extensions of all objects, whether the file lists them or not.
std::set<std::string> names_that_stand_in(const nlohmann::json& root) {
    std::set<std::string> names;
    std::vector<const nlohmann::json*> open = {&root};
    while (!open.empty()) {
        const nlohmann::json& value = *open.back();
        open.pop_back();
        if (!value.is_structured()) continue;
        for (const auto& [key, member] : value.items()) {
            // Applications keep what they like in extras.
            if (value.is_object() && key == "extras") continue;
            if (value.is_object() && key == "extensions" && member.is_object()) {
                for (const auto& [name, ignored] : member.items()) names.insert(name);
            }
            if (member.is_structured()) open.push_back(&member);
        }
    }
    return names;
}

}  // namespace

void check_gltf_extensions(const GltfObject& root, const nlohmann::json& document, Notes& notes) {
    std::string missing;
    std::size_t count = 0;
    for (const std::string& name : root.texts("extensionsRequired")) {
        if (may_be_required(name)) continue;
        missing += (missing.empty() ? "" : ", ") + name;
        ++count;
    }
    if (count != 0) {
        throw root.error(
            fmt::format("extensionsRequired: {} {} not supported: export the scene without {}",
                        missing, count == 1 ? "is" : "are", count == 1 ? "it" : "them"));
    }
    std::set<std::string> names = names_that_stand_in(document);
    for (const std::string& name : root.texts("extensionsUsed")) names.insert(name);
    std::size_t noted = 0;
    for (const std::string& name : names) {
        if (may_be_required(name)) continue;
        if (++noted <= kMaxExtensionsNamed) {
            notes.add(fmt::format("the extension {} is not supported: left out", shown(name)));
        }
    }
    if (noted > kMaxExtensionsNamed) {
        notes.add(fmt::format("{} further extensions are not supported: left out",
                              noted - kMaxExtensionsNamed));
    }
}

}  // namespace scotty::scenes
