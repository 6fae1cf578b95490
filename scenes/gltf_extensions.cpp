#include <fmt/format.h>

#include <algorithm>
#include <array>

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

bool may_be_required(const std::string& name) {
    return contains(kSupported, name) || contains(kAboutTextures, name) ||
           contains(kHarmless, name);
}

}  // namespace

void check_gltf_extensions(const GltfObject& root, Notes& notes) {
    std::string missing;
    for (const std::string& name : root.texts("extensionsRequired")) {
        if (may_be_required(name)) continue;
        missing += (missing.empty() ? "" : ", ") + name;
    }
    if (!missing.empty()) {
        throw root.error(fmt::format(
            "extensionsRequired: {} is not supported: export the scene without it", missing));
    }
    for (const std::string& name : root.texts("extensionsUsed")) {
        if (may_be_required(name)) continue;
        notes.add(fmt::format("the extension {} is not supported: left out", name));
    }
}

}  // namespace scotty::scenes
