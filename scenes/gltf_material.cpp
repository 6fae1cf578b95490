#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "scenes/gltf_parts.h"
#include "scenes/material_mapping.h"

namespace scotty::scenes {

using reference::Material;
using reference::MaterialKind;
using reference::Vec3;

namespace {

/// Members of an object whose names end like that of a texture. Ambient occlusion is left out: it
/// stands for light that a path tracer computes.
std::size_t textures_in(const GltfObject& object) {
    constexpr std::string_view kEnd = "Texture";
    std::size_t count = 0;
    for (const std::string& key : object.keys()) {
        const bool is_texture = key.size() > kEnd.size() &&
                                key.compare(key.size() - kEnd.size(), kEnd.size(), kEnd) == 0;
        if (is_texture && key != "occlusionTexture") ++count;
    }
    return count;
}

void note_textures(const GltfObject& object, Notes& notes) {
    std::size_t count = textures_in(object);
    if (const auto pbr = object.object("pbrMetallicRoughness")) count += textures_in(*pbr);
    if (const auto extensions = object.object("extensions")) {
        for (const std::string& name : extensions->keys()) {
            if (const auto extension = extensions->object(name.c_str())) {
                count += textures_in(*extension);
            }
        }
    }
    notes.add("a texture is not supported: the plain colour is used", count);
}

Vec3 emission_of(const GltfObject& object, Notes& notes) {
    const auto factor = object.numbers<3>("emissiveFactor", {0, 0, 0});
    const auto extension = object.extension("KHR_materials_emissive_strength");
    const double strength = extension ? extension->number("emissiveStrength", 1.0) : 1.0;
    Vec3 emission;
    for (int k = 0; k < 3; ++k) {
        const double value = factor[static_cast<std::size_t>(k)] * strength;
        emission[k] = static_cast<float>(value);
        if (value < 0.0 || !std::isfinite(emission[k])) {
            throw object.error(
                fmt::format("emissiveFactor: expected nothing negative or too large "
                            "for a float, found {}",
                            value));
        }
    }
    if (reference::is_zero(emission)) return emission;
    if (object.has("emissiveTexture")) {
        // Such textures are black but for a few lamps: the whole surface would glow.
        notes.add("an emissive texture is not supported: the surface does not glow");
        return Vec3(0.0f);
    }
    if (object.flag("doubleSided", false)) {
        notes.add(
            "emission on both sides is not supported: a double-sided material emits light on its "
            "front side only");
    }
    return emission;
}

float refraction_index(const GltfObject& object, Notes& notes) {
    const auto extension = object.extension("KHR_materials_ior");
    const double ior = extension ? extension->number("ior", 1.5) : 1.5;
    if (ior >= 0.01 && ior <= 100.0) return static_cast<float>(ior);
    notes.add("an index of refraction out of range: 1.5 is used");
    return 1.5f;
}

Material glass(const GltfObject& object, const Vec3& base, double roughness, Notes& notes) {
    Material material;
    material.kind = MaterialKind::glass;
    material.reflectance = Vec3(1.0f);
    material.transmittance = clamped_tint(base, notes);
    material.ior = refraction_index(object, notes);
    if (roughness > 0.001) notes.add("rough transmission is not supported: clear glass");
    const auto volume = object.extension("KHR_materials_volume");
    if (!volume || volume->number("thicknessFactor", 0.0) == 0.0) {
        notes.add(
            "transmission through a thin wall is not supported: it refracts like solid glass");
    }
    return material;
}

/// Whether the surface can be seen; alpha between 0 and 1 is opaque, with a note.
bool is_visible(const GltfObject& object, double alpha, bool has_base_texture, Notes& notes) {
    const std::string mode = object.text("alphaMode", "OPAQUE");
    if (mode == "OPAQUE") return true;
    if (mode != "MASK" && mode != "BLEND") {
        throw object.error(
            fmt::format("alphaMode: expected OPAQUE, MASK or BLEND, found '{}'", mode));
    }
    const bool is_mask = mode == "MASK";
    if (is_mask ? alpha < object.number("alphaCutoff", 0.5) : alpha <= 0.0) {
        notes.add("a material that is all transparent: what it covers is left out");
        return false;
    }
    if (has_base_texture || (!is_mask && alpha < 1.0)) {
        notes.add(is_mask ? "an alpha mask is not supported: opaque"
                          : "partial opacity is not supported: opaque");
    }
    return true;
}

}  // namespace

GltfMaterial read_gltf_material(const GltfObject& object, Notes& notes) {
    note_textures(object, notes);
    const auto pbr = object.object("pbrMetallicRoughness");
    const auto gloss = object.extension("KHR_materials_pbrSpecularGlossiness");
    const char* key = gloss ? "diffuseFactor" : "baseColorFactor";
    const auto& source = gloss ? gloss : pbr;
    const std::array<double, 4> white = {1, 1, 1, 1};
    const auto colour = source ? source->numbers<4>(key, white) : white;
    const Vec3 base = rounded({colour[0], colour[1], colour[2]});
    double metallic = pbr ? pbr->number("metallicFactor", 1.0) : 1.0;
    double roughness = pbr ? pbr->number("roughnessFactor", 1.0) : 1.0;
    if (pbr && pbr->has("metallicRoughnessTexture")) {
        notes.add("a texture of metal and roughness is not supported: diffuse");
        metallic = 0.0;
        roughness = 1.0;
    }
    if (gloss) {
        notes.add("specular highlights are not supported: diffuse part only");
        metallic = 0.0;
        roughness = 1.0;
    }
    if (object.extension("KHR_materials_unlit")) {
        notes.add("an unlit material is not supported: it is lit like a diffuse one");
        metallic = 0.0;
        roughness = 1.0;
    }
    const auto extension = object.extension("KHR_materials_transmission");
    const double transmission = extension ? extension->number("transmissionFactor", 0.0) : 0.0;
    GltfMaterial out;
    if (transmission >= 0.999) {
        out.material = glass(object, base, roughness, notes);
    } else {
        out.material = material_from_metallic_roughness(base, static_cast<float>(metallic),
                                                        static_cast<float>(roughness), notes);
        if (transmission > 0.0) notes.add("partial transmission is not supported: opaque");
    }
    out.material.emission = emission_of(object, notes);
    const bool has_texture =
        source && (source->has("baseColorTexture") || source->has("diffuseTexture"));
    out.is_visible = is_visible(object, colour[3], has_texture, notes);
    return out;
}

}  // namespace scotty::scenes
