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

std::optional<Light> make_light(const ColladaDocument& document, pugi::xml_node element,
                                const Affine& place, Notes& notes) {
    const std::string kind = element.name();
    const Vec3 radiance = radiance_of(document, element);
    if (kind == "area") return area_light(radiance, place, notes);
    if (kind == "point" || kind == "spot") {
        if (kind == "spot") notes.add("a spot light's cone is not supported: a point light");
        const double constant = document.number(element.child("constant_attenuation"), 0.0);
        const double linear = document.number(element.child("linear_attenuation"), 0.0);
        const double quadratic = document.number(element.child("quadratic_attenuation"), 1.0);
        if (constant != 0.0 || linear != 0.0 || quadratic != 1.0) {
            notes.add(
                "a point light's attenuation is not supported: light falls off with the "
                "squared distance");
        }
        return point_light(rounded(place.point({0, 0, 0})), radiance);
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

}  // namespace

std::optional<Light> read_light(const ColladaDocument& document, pugi::xml_node light,
                                const Affine& place, Notes& notes) {
    const pugi::xml_node extra = scotty3d_extra(light);
    if (extra && is_known(extra.name())) return make_light(document, extra, place, notes);
    if (extra) {
        notes.add(
            fmt::format("the light <{}> is not supported: its common form is used", extra.name()));
    }
    for (const pugi::xml_node child : light.child("technique_common").children()) {
        if (is_known(child.name())) return make_light(document, child, place, notes);
    }
    notes.add("a light of no known kind: left out");
    return std::nullopt;
}

std::optional<reference::Camera> read_camera(const ColladaDocument& document, pugi::xml_node camera,
                                             const Affine& place, Notes& notes) {
    const pugi::xml_node perspective =
        camera.child("optics").child("technique_common").child("perspective");
    if (!perspective) {
        notes.add("a camera that is not a perspective one: left out");
        return std::nullopt;
    }
    const double aspect = document.number(perspective.child("aspect_ratio"), 1.0);
    const bool has_height = !perspective.child("yfov").empty();
    const pugi::xml_node angle = perspective.child(has_height ? "yfov" : "xfov");
    if (!angle) throw document.error(perspective, "expected a <yfov> or <xfov> inside");
    const double degrees = document.number(angle, 0.0);
    if (!(degrees > 0.0 && degrees < 180.0)) {
        throw document.error(angle, fmt::format("expected 0 to 180 degrees, found {}", degrees));
    }
    if (!(aspect > 0.0)) {
        throw document.error(perspective.child("aspect_ratio"),
                             fmt::format("expected more than 0, found {}", aspect));
    }
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
    const double tangent = std::tan(0.5 * degrees * kDegree) / (has_height ? 1.0 : aspect);
    reference::Camera out =
        look_at(Vec3(0.0f, 0.0f, 0.0f), forward, up, static_cast<float>(tangent));
    out.position = position;
    return out;
}

}  // namespace scotty::scenes
