#include <algorithm>
#include <cstring>

#include "scenes/collada_parts.h"

namespace scotty::scenes {

using reference::Material;
using reference::MaterialKind;
using reference::Vec3;

namespace {

/// A tint, clamped to what a surface can do.
Vec3 tint(const Point& colour, Notes& notes) {
    Point clamped{};
    for (std::size_t k = 0; k < 3; ++k) clamped[k] = std::clamp(colour[k], 0.0, 1.0);
    if (clamped != colour) notes.add("a reflectance or transmittance beyond 0 to 1: clamped");
    return rounded(clamped);
}

Point child_colour(const ColladaDocument& document, pugi::xml_node parent, const char* child) {
    const pugi::xml_node element = parent.child(child);
    if (!element) throw document.error(parent, fmt::format("expected a <{}> inside", child));
    return document.colour(element);
}

double refraction_index(const ColladaDocument& document, pugi::xml_node extra) {
    const pugi::xml_node ior = extra.child("ior");
    if (!ior) throw document.error(extra, "expected an <ior> inside");
    const double value = document.number(ior, 0.0);
    if (!(value >= 0.01 && value <= 100.0)) {
        throw document.error(ior, fmt::format("expected 0.01 to 100, found {}", value));
    }
    return value;
}

void note_roughness(const ColladaDocument& document, pugi::xml_node extra, Notes& notes) {
    if (document.number(extra.child("roughness"), 0.0) == 0.0) return;
    notes.add(
        fmt::format("the roughness of <{}> is not supported: perfectly smooth", extra.name()));
}

/// A colour of the common profile: <color>, or <param> that refers to a <newparam>.
std::optional<Point> common_colour(const ColladaDocument& document, pugi::xml_node effect,
                                   pugi::xml_node channel, Notes& notes) {
    if (const pugi::xml_node colour = channel.child("color")) return document.colour(colour);
    if (channel.child("texture")) {
        notes.add(fmt::format("the texture of <{}> is not supported: grey 0.5", channel.name()));
        return Point{0.5, 0.5, 0.5};
    }
    if (const pugi::xml_node reference = channel.child("param")) {
        const pugi::xml_node parameter =
            effect.child("profile_COMMON")
                .find_child_by_attribute("newparam", "sid", reference.attribute("ref").value());
        for (const char* type : {"float3", "float4"}) {
            if (const pugi::xml_node value = parameter.child(type)) return document.colour(value);
        }
        throw document.error(reference, "there is no <newparam> of float3 or float4 that it names");
    }
    return std::nullopt;
}

bool is_black(const std::optional<Point>& colour) { return !colour || *colour == Point{}; }

Material read_common(const ColladaDocument& document, pugi::xml_node effect, Notes& notes) {
    Material material;
    pugi::xml_node shader;
    for (const char* name : {"phong", "blinn", "lambert", "constant"}) {
        const pugi::xml_node found = effect.child("profile_COMMON").child("technique").child(name);
        if (found) shader = found;
    }
    if (!shader) {
        notes.add("an effect without a common profile: grey 0.5");
        material.reflectance = Vec3(0.5f, 0.5f, 0.5f);
        return material;
    }
    const auto channel = [&](const char* name) {
        return common_colour(document, effect, shader.child(name), notes);
    };
    material.reflectance = tint(channel("diffuse").value_or(Point{}), notes);
    const Point emission = channel("emission").value_or(Point{});
    for (const double value : emission) {
        if (value < 0.0)
            throw document.error(shader.child("emission"), "expected nothing negative");
    }
    material.emission = rounded(emission);
    if (!is_black(channel("specular"))) {
        notes.add("specular highlights of the common profile are not supported: diffuse part only");
    }
    if (!is_black(channel("reflective")) &&
        document.number(shader.child("reflectivity").child("float"), 1.0) != 0.0) {
        notes.add("reflectivity of the common profile is not supported: diffuse part only");
    }
    const bool opaque = document.number(shader.child("transparency").child("float"), 1.0) == 1.0;
    if (!opaque || shader.child("transparent").child("texture")) {
        notes.add("transparency of the common profile is not supported: opaque");
    }
    return material;
}

}  // namespace

Material read_material(const ColladaDocument& document, pugi::xml_node material, Notes& notes) {
    const pugi::xml_node instance = material.child("instance_effect");
    if (!instance) throw document.error(material, "expected an <instance_effect> inside");
    const pugi::xml_node effect = document.target(instance, "url", "effect");
    pugi::xml_node extra = scotty3d_extra(effect);
    if (!extra) extra = scotty3d_extra(effect.child("profile_COMMON"));
    const std::string kind = extra.name();
    Material result;
    if (kind == "diffuse") {
        result.reflectance = tint(
            child_colour(document, extra, extra.child("albedo") ? "albedo" : "reflectance"), notes);
    } else if (kind == "mirror") {
        result.kind = MaterialKind::mirror;
        result.reflectance = tint(child_colour(document, extra, "reflectance"), notes);
        note_roughness(document, extra, notes);
    } else if (kind == "glass") {
        result.kind = MaterialKind::glass;
        result.reflectance = tint(child_colour(document, extra, "reflectance"), notes);
        result.transmittance = tint(child_colour(document, extra, "transmittance"), notes);
        result.ior = static_cast<float>(refraction_index(document, extra));
        note_roughness(document, extra, notes);
    } else if (kind == "refraction") {
        // Black reflection: what Fresnel's equations reflect is lost, as the original never made
        // it.
        result.kind = MaterialKind::glass;
        result.transmittance = tint(child_colour(document, extra, "transmittance"), notes);
        result.ior = static_cast<float>(refraction_index(document, extra));
        note_roughness(document, extra, notes);
        notes.add("<refraction> is approximated by glass that does not reflect");
    } else if (kind == "emission") {
        const Point radiance = child_colour(document, extra, "radiance");
        for (const double value : radiance) {
            if (value < 0.0) throw document.error(extra, "radiance: expected nothing negative");
        }
        result.emission = rounded(radiance);
    } else {
        if (!kind.empty()) {
            notes.add(
                fmt::format("the material <{}> is not supported: its common diffuse colour "
                            "is used",
                            kind));
        }
        result = read_common(document, effect, notes);
    }
    return result;
}

}  // namespace scotty::scenes
