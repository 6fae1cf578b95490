#include <algorithm>
#include <array>
#include <cstring>

#include "scenes/collada_parts.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Light;

namespace {

/// A light's colour times its intensity, where the latter is given.
Vec3 radiance_of(const ColladaDocument& document, pugi::xml_node light) {
    const pugi::xml_node element = light.child("color");
    if (!element) throw document.error(light, "expected a <color> inside");
    Point colour = document.colour(element);
    const double intensity = document.number(light.child("intensity"), 1.0);
    for (double& value : colour) {
        value *= intensity;
        if (value < 0.0) throw document.error(light, "colour: expected nothing negative");
    }
    return rounded(colour);
}

/// The unit square around the node's origin, lit towards the node's -z: the columns of its matrix
/// are the light's edges.
std::optional<Light> area_light(const Vec3& radiance, const Affine& place, Notes& notes) {
    const Vec3 edge_x = rounded(place.vector({1, 0, 0}));
    const Vec3 edge_y = rounded(place.vector({0, 1, 0}));
    const Vec3 corner = rounded(place.point({-0.5, -0.5, 0}));
    // cross(edge_x, edge_y) is the side of +z in a right-handed node, so the edges change places.
    Light light = parallelogram_light(corner, edge_y, edge_x, radiance);
    if (reference::dot(light.normal, rounded(place.vector({0, 0, -1}))) < 0.0f) {
        light = parallelogram_light(corner, edge_x, edge_y, radiance);
    }
    if (!(light.area > 0.0f)) {
        notes.add("an area light without area: left out");
        return std::nullopt;
    }
    return light;
}

/// What a point light's intensity is divided by, so that light that falls off with the squared
/// distance is what the file means. COLLADA divides by constant + linear d + quadratic d^2; a light
/// without any of these is meant to be physical, as the exporters of such files do.
double quadratic_attenuation(const ColladaDocument& document, pugi::xml_node light, Notes& notes) {
    std::array<double, 3> factors{};
    const std::array<const char*, 3> names = {"constant_attenuation", "linear_attenuation",
                                              "quadratic_attenuation"};
    bool is_given = false;
    for (std::size_t k = 0; k < 3; ++k) {
        const pugi::xml_node element = light.child(names[k]);
        is_given |= !element.empty();
        factors[k] = document.number(element, 0.0);
        if (factors[k] < 0.0) throw document.error(element, "expected nothing negative");
    }
    if (!is_given) return 1.0;
    if (factors[0] == 0.0 && factors[1] == 0.0 && factors[2] > 0.0) return factors[2];
    notes.add(
        "a point light's attenuation that is not purely quadratic is not supported: light falls "
        "off with the squared distance");
    return 1.0;
}

/// Adds the cone of a <spot>, whose angle is that from one side to the other, to a point light.
std::optional<Light> in_cone(const ColladaDocument& document, pugi::xml_node spot,
                             const Light& point, const Affine& place, Notes& notes) {
    const pugi::xml_node element = spot.child("falloff_angle");
    const double degrees = document.number(element, 180.0);
    if (!(degrees > 0.0)) {
        throw document.error(element, fmt::format("expected more than 0, found {}", degrees));
    }
    if (document.number(spot.child("falloff_exponent"), 0.0) != 0.0) {
        notes.add("a spot light's <falloff_exponent> is not supported: its cone has a hard edge");
    }
    if (degrees >= 360.0) return point;
    // A cone that is too narrow for a float keeps some width.
    constexpr float kNarrowest = 0.999999f;
    const auto cosine = static_cast<float>(std::cos(0.5 * degrees * kDegree));
    const float edge = std::min(cosine, kNarrowest);
    const Light light =
        spot_light(point.position, rounded(place.vector({0, 0, -1})), point.radiance, {edge, edge});
    if (!reference::is_zero(light.normal)) return light;
    notes.add("a spot light without direction: left out");
    return std::nullopt;
}

std::optional<Light> placed_point_light(const ColladaDocument& document, pugi::xml_node element,
                                        const Vec3& colour, const Affine& place, double metres,
                                        Notes& notes) {
    const double factor = metres * metres / quadratic_attenuation(document, element, notes);
    const Vec3 intensity = rounded({colour.x * factor, colour.y * factor, colour.z * factor});
    const Light light = point_light(rounded(place.point({0, 0, 0})), intensity);
    const bool is_spot = std::strcmp(element.name(), "spot") == 0;
    return is_spot ? in_cone(document, element, light, place, notes) : light;
}

std::optional<Light> make_light(const ColladaDocument& document, pugi::xml_node element,
                                const Affine& place, double metres, Notes& notes) {
    const std::string kind = element.name();
    const Vec3 radiance = radiance_of(document, element);
    if (kind == "area") return area_light(radiance, place, notes);
    if (kind == "point" || kind == "spot") {
        return placed_point_light(document, element, radiance, place, metres, notes);
    }
    if (kind == "directional") {
        const Light light = directional_light(rounded(place.vector({0, 0, -1})), radiance);
        if (reference::is_zero(light.normal)) {
            notes.add("a directional light without direction: left out");
            return std::nullopt;
        }
        return light;
    }
    return kind == "hemisphere" ? hemisphere_light(radiance) : environment_light(radiance);
}

bool is_known(const std::string& kind) {
    for (const char* known : {"area", "point", "spot", "directional", "hemisphere", "ambient"}) {
        if (kind == known) return true;
    }
    return false;
}

/// FCOLLADA's exporters keep a light's strength in an extra of theirs.
void note_foreign_intensity(const ColladaDocument& document, pugi::xml_node light, Notes& notes) {
    for (const pugi::xml_node extra : light.children("extra")) {
        for (const pugi::xml_node technique : extra.children("technique")) {
            const pugi::xml_node intensity = technique.child("intensity");
            if (!intensity || document.number(intensity, 1.0) == 1.0) continue;
            notes.add(
                fmt::format("a light's <intensity> of the profile {} is not supported: its "
                            "colour alone is used",
                            technique.attribute("profile").value()));
        }
    }
}

}  // namespace

std::optional<Light> read_light(const ColladaDocument& document, pugi::xml_node light,
                                const Affine& place, double metres, Notes& notes) {
    const pugi::xml_node extra = scotty3d_extra(light);
    if (extra && is_known(extra.name())) return make_light(document, extra, place, metres, notes);
    if (extra) {
        notes.add(
            fmt::format("the light <{}> is not supported: its common form is used", extra.name()));
    }
    for (const pugi::xml_node child : light.child("technique_common").children()) {
        if (!is_known(child.name())) continue;
        note_foreign_intensity(document, light, notes);
        return make_light(document, child, place, metres, notes);
    }
    notes.add("a light of no known kind: left out");
    return std::nullopt;
}

namespace {

struct FieldOfView {
    float tan_half_height = 0.5f;
    float tan_half_width = 0.0f;  ///< as in reference::Camera
};

/// Degrees of a field of view as the tangent of half of it.
float tan_half(const ColladaDocument& document, pugi::xml_node angle) {
    const double degrees = document.number(angle, 0.0);
    if (!(degrees > 0.0 && degrees < 180.0)) {
        throw document.error(angle, fmt::format("expected 0 to 180 degrees, found {}", degrees));
    }
    return static_cast<float>(std::tan(0.5 * degrees * kDegree));
}

/// COLLADA says it by <yfov>, by <xfov>, by both, or by one of them and an <aspect_ratio>. The
/// height is kept where it is known; a width alone has to wait for the picture.
FieldOfView read_field_of_view(const ColladaDocument& document, pugi::xml_node perspective) {
    FieldOfView view;
    const pugi::xml_node ratio = perspective.child("aspect_ratio");
    const double aspect = document.number(ratio, 1.0);
    if (!(aspect > 0.0)) {
        throw document.error(ratio, fmt::format("expected more than 0, found {}", aspect));
    }
    const pugi::xml_node height = perspective.child("yfov");
    const pugi::xml_node width = perspective.child("xfov");
    if (!height && !width) throw document.error(perspective, "expected a <yfov> or <xfov> inside");
    if (height) {
        view.tan_half_height = tan_half(document, height);
    } else if (ratio) {
        view.tan_half_height = tan_half(document, width) / static_cast<float>(aspect);
    } else {
        view.tan_half_width = tan_half(document, width);
    }
    return view;
}

}  // namespace

std::optional<reference::Camera> read_camera(const ColladaDocument& document, pugi::xml_node camera,
                                             const Affine& place, Notes& notes) {
    const pugi::xml_node perspective =
        camera.child("optics").child("technique_common").child("perspective");
    if (!perspective) {
        notes.add("a camera that is not a perspective one: left out");
        return std::nullopt;
    }
    const FieldOfView view = read_field_of_view(document, perspective);
    const Vec3 position = rounded(place.point({0, 0, 0}));
    const Vec3 forward = rounded(unit(place.vector({0, 0, -1})));
    Vec3 up = rounded(unit(place.vector({0, 1, 0})));
    if (reference::is_zero(forward)) {
        notes.add("a camera whose transform leaves it no direction: left out");
        return std::nullopt;
    }
    if (reference::length(reference::cross(forward, up)) < 1e-4f) {
        notes.add("a camera whose transform does not say what is up: the scene's up is used");
        const bool vertical = std::abs(forward.y) > 0.999f;
        up = vertical ? Vec3(0.0f, 0.0f, -1.0f) : Vec3(0.0f, 1.0f, 0.0f);
    }
    reference::Camera out = look_at(Vec3(0.0f, 0.0f, 0.0f), forward, up, view.tan_half_height);
    out.tan_half_width = view.tan_half_width;
    out.position = position;
    return out;
}

}  // namespace scotty::scenes
