#include "scenes/material_mapping.h"

#include <algorithm>

namespace scotty::scenes {

using reference::Material;
using reference::MaterialKind;
using reference::Vec3;

Vec3 clamped_tint(const Vec3& colour, Notes& notes) {
    Vec3 clamped;
    for (int k = 0; k < 3; ++k) clamped[k] = colour[k] > 0.0f ? std::min(colour[k], 1.0f) : 0.0f;
    if (clamped != colour) notes.add("a reflectance or transmittance beyond 0 to 1: clamped");
    return clamped;
}

Material material_from_metallic_roughness(const Vec3& base_colour, float metallic, float roughness,
                                          Notes& notes) {
    Material material;
    material.reflectance = clamped_tint(base_colour, notes);
    if (metallic > 0.001f && metallic < 0.999f) {
        notes.add("a surface between metal and not is not supported: it is what it is more of");
    }
    if (metallic < 0.5f) {
        if (roughness < 1.0f) notes.add("gloss on what is no metal is not supported: diffuse");
    } else if (roughness <= 0.001f) {
        material.kind = MaterialKind::mirror;
    } else {
        material.kind = MaterialKind::conductor;
        material.ior = std::min(roughness, 1.0f);
    }
    return material;
}

}  // namespace scotty::scenes
