#include "scenes/assimp_material.h"

#include <assimp/ObjMaterial.h>
#include <assimp/material.h>

#include <algorithm>
#include <cmath>

namespace scotty::scenes {

using reference::Material;
using reference::MaterialKind;
using reference::Vec3;

namespace {

Vec3 colour(const aiMaterial& source, const char* key, const Vec3& standard) {
    aiColor4D value;
    if (source.Get(key, 0, 0, value) != AI_SUCCESS) return standard;
    return {value.r, value.g, value.b};
}

float number(const aiMaterial& source, const char* key, float standard) {
    float value = 0.0f;
    return source.Get(key, 0, 0, value) == AI_SUCCESS ? value : standard;
}

/// NaN becomes 0.
Vec3 tint(const Vec3& value, Notes& notes) {
    Vec3 clamped;
    for (int k = 0; k < 3; ++k) clamped[k] = value[k] > 0.0f ? std::min(value[k], 1.0f) : 0.0f;
    if (clamped != value) notes.add("a reflectance or transmittance beyond 0 to 1: clamped");
    return clamped;
}

float refraction_index(const aiMaterial& source, Notes& notes) {
    const float ior = number(source, "$mat.refracti", 1.5f);
    if (ior >= 0.01f && ior <= 100.0f) return ior;
    notes.add("an index of refraction out of range: 1.5 is used");
    return 1.5f;
}

void note_textures(const aiMaterial& source, Notes& notes) {
    unsigned textures = 0;
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; ++type) {
        textures += source.GetTextureCount(static_cast<aiTextureType>(type));
    }
    notes.add("a texture is not supported: the plain colour is used", textures);
}

/// OBJ's illumination model; -1 where the file is no OBJ.
int illumination(const aiMaterial& source) {
    int model = -1;
    return source.Get(AI_MATKEY_OBJ_ILLUM, model) == AI_SUCCESS ? model : -1;
}

const Vec3 kWhite(1.0f, 1.0f, 1.0f);

Vec3 white_if_black(const Vec3& value) { return reference::is_zero(value) ? kWhite : value; }

}  // namespace

Material from_assimp(const aiMaterial& source, Notes& notes) {
    note_textures(source, notes);
    Material material;
    const Vec3 base = colour(source, "$clr.base", colour(source, "$clr.diffuse", Vec3(0.5f)));
    const Vec3 emission = colour(source, "$clr.emissive", Vec3(0.0f));
    for (int k = 0; k < 3; ++k) {
        material.emission[k] =
            emission[k] > 0.0f && std::isfinite(emission[k]) ? emission[k] : 0.0f;
    }
    const int model = illumination(source);
    const bool is_pbr = number(source, "$mat.metallicFactor", -1.0f) >= 0.0f;
    const float metal = number(source, "$mat.metallicFactor", 0.0f);
    const float roughness = number(source, "$mat.roughnessFactor", 1.0f);
    const float transmission = number(source, "$mat.transmission.factor", 0.0f);
    const bool is_mirror =
        model == 3 || model == 5 || (is_pbr && metal >= 0.999f && roughness <= 0.001f);
    const bool is_glass = model == 4 || model == 6 || model == 7 || transmission >= 0.999f;
    if (is_glass) {
        material.kind = MaterialKind::glass;
        material.ior = refraction_index(source, notes);
        if (is_pbr) {
            material.reflectance = kWhite;
            material.transmittance = tint(base, notes);
        } else {
            material.reflectance =
                tint(white_if_black(colour(source, "$clr.specular", kWhite)), notes);
            material.transmittance =
                tint(white_if_black(colour(source, "$clr.transparent", kWhite)), notes);
        }
    } else if (is_mirror) {
        material.kind = MaterialKind::mirror;
        material.reflectance =
            tint(is_pbr ? base : white_if_black(colour(source, "$clr.specular", kWhite)), notes);
    } else {
        material.reflectance = tint(base, notes);
        if (is_pbr && (metal > 0.0f || roughness < 1.0f)) {
            notes.add("metal and gloss between the extremes are not supported: diffuse");
        }
        if (transmission > 0.0f) notes.add("partial transmission is not supported: opaque");
        if (!is_pbr && !reference::is_zero(colour(source, "$clr.specular", Vec3(0.0f))) &&
            model >= 0) {
            notes.add("specular highlights are not supported: diffuse part only");
        }
        if (number(source, "$mat.opacity", 1.0f) < 1.0f) {
            notes.add("partial opacity is not supported: opaque");
        }
    }
    return material;
}

}  // namespace scotty::scenes
