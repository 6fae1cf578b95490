#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>

#include "scenes/collada_parts.h"
#include "scenes/file_scene.h"
#include "scenes/material_mapping.h"

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

/// An effect's common profile, as one material uses it.
class CommonProfile {
 public:
    CommonProfile(const ColladaDocument& document, pugi::xml_node effect, pugi::xml_node instance,
                  Notes& notes)
        : document_(document),
          effect_(effect),
          instance_(instance),
          profile_(effect.child("profile_COMMON")),
          notes_(notes) {
        for (const char* name : {"phong", "blinn", "lambert", "constant"}) {
            const pugi::xml_node found = profile_.child("technique").child(name);
            if (found) shader_ = found;
        }
    }

    Material read() const {
        Material material;
        if (!shader_) {
            notes_.add("an effect without a common profile: grey 0.5");
            material.reflectance = Vec3(kDefaultReflectance);
            return material;
        }
        material.emission = rounded(emission());
        material.reflectance = tint(diffuse(material), notes_);
        note_the_rest();
        return material;
    }

 private:
    /// A <color>, or what a <param> refers to. Nothing for a texture or where nothing is there.
    std::optional<Point> colour(pugi::xml_node channel) const {
        if (const pugi::xml_node element = channel.child("color")) return document_.colour(element);
        if (const pugi::xml_node reference = channel.child("param")) {
            return document_.colour(parameter(reference, {"float3", "float4"}));
        }
        return std::nullopt;
    }
    double number(const char* channel, double standard) const {
        const pugi::xml_node parent = shader_.child(channel);
        if (const pugi::xml_node reference = parent.child("param")) {
            return document_.number(parameter(reference, {"float"}), standard);
        }
        return document_.number(parent.child("float"), standard);
    }
    double alpha(pugi::xml_node channel) const {
        pugi::xml_node element = channel.child("color");
        if (!element && channel.child("param")) {
            element = parameter(channel.child("param"), {"float3", "float4"});
        }
        if (!element) return 1.0;
        const std::vector<double> values = document_.numbers(element);
        return values.size() > 3 ? values[3] : 1.0;
    }

    /// The value that a <param> names: set by the material, or new in the effect or its profile.
    pugi::xml_node parameter(pugi::xml_node reference,
                             std::initializer_list<const char*> types) const {
        const char* name = reference.attribute("ref").value();
        for (const pugi::xml_node found :
             {instance_.find_child_by_attribute("setparam", "ref", name),
              profile_.child("technique").find_child_by_attribute("newparam", "sid", name),
              profile_.find_child_by_attribute("newparam", "sid", name),
              effect_.find_child_by_attribute("newparam", "sid", name)}) {
            for (const char* type : types) {
                if (const pugi::xml_node value = found.child(type)) return value;
            }
        }
        throw document_.error(reference, fmt::format("there is no <newparam> of {} that it names",
                                                     fmt::join(types, " or ")));
    }

    Point emission() const {
        const pugi::xml_node channel = shader_.child("emission");
        if (channel.child("texture")) {
            notes_.add("the texture of <emission> is not supported: it does not shine");
        }
        const Point value = colour(channel).value_or(Point{});
        for (const double part : value) {
            if (part < 0.0) throw document_.error(channel, "expected nothing negative");
        }
        return value;
    }

    Point diffuse(const Material& material) const {
        const pugi::xml_node channel = shader_.child("diffuse");
        if (channel.child("texture")) {
            notes_.add("the texture of <diffuse> is not supported: grey 0.5");
            return widened(Vec3(kDefaultReflectance));
        }
        const std::optional<Point> value = colour(channel);
        const bool is_constant = std::strcmp(shader_.name(), "constant") == 0;
        if (!value && !is_constant && reference::is_zero(material.emission)) {
            notes_.add("an effect without a <diffuse>: black");
        }
        return value.value_or(Point{});
    }

    bool has(const char* name) const {
        const pugi::xml_node channel = shader_.child(name);
        return channel.child("texture") || colour(channel).value_or(Point{}) != Point{};
    }

    /// How much of what is behind it the surface hides, by the rule of its `opaque` attribute.
    double opacity() const {
        const pugi::xml_node channel = shader_.child("transparent");
        const double factor = number("transparency", 1.0);
        const std::string mode = channel.attribute("opaque").as_string("A_ONE");
        if (mode == "A_ONE") return alpha(channel) * factor;
        if (mode == "A_ZERO") return 1.0 - alpha(channel) * factor;
        // Without a colour, white: RGB_ZERO then means invisible, RGB_ONE opaque.
        const Point rgb = colour(channel).value_or(Point{1.0, 1.0, 1.0});
        const auto [least, most] = std::minmax({rgb[0], rgb[1], rgb[2]});
        if (mode == "RGB_ONE") return least * factor;
        if (mode == "RGB_ZERO") return 1.0 - most * factor;
        throw document_.error(channel, fmt::format("opaque: expected A_ONE, A_ZERO, RGB_ONE or "
                                                   "RGB_ZERO, found '{}'",
                                                   mode));
    }

    void note_the_rest() const {
        if (has("specular")) {
            notes_.add(
                "specular highlights of the common profile are not supported: diffuse part only");
        }
        if (has("reflective") && number("reflectivity", 1.0) != 0.0) {
            notes_.add("reflectivity of the common profile is not supported: diffuse part only");
        }
        const pugi::xml_node transparent = shader_.child("transparent");
        const bool is_given = transparent || shader_.child("transparency");
        if (is_given && (transparent.child("texture") || opacity() != 1.0)) {
            notes_.add("transparency of the common profile is not supported: opaque");
        }
        for (const pugi::xml_node owner : {effect_, profile_, profile_.child("technique")}) {
            for (const pugi::xml_node extra : owner.children("extra")) {
                if (!extra.child("technique").child("bump")) continue;
                notes_.add("a bump or normal map is not supported: left out");
            }
        }
    }

    const ColladaDocument& document_;
    pugi::xml_node effect_;
    pugi::xml_node instance_;
    pugi::xml_node profile_;
    pugi::xml_node shader_;
    Notes& notes_;
};

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
        const Vec3 colour = tint(child_colour(document, extra, "reflectance"), notes);
        const double roughness = document.number(extra.child("roughness"), 0.0);
        if (!(roughness >= 0.0 && roughness <= 1.0)) {
            throw document.error(extra,
                                 fmt::format("roughness: expected 0 to 1, found {}", roughness));
        }
        result =
            material_from_metallic_roughness(colour, 1.0f, static_cast<float>(roughness), notes);
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
        result = CommonProfile(document, effect, instance, notes).read();
    }
    return result;
}

}  // namespace scotty::scenes
