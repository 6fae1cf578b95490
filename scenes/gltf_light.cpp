#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/gltf_parts.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Camera;
using reference::Light;

namespace {

Vec3 radiance_of(const GltfObject& light) {
    const auto colour = light.numbers<3>("color", {1, 1, 1});
    const double intensity = light.number("intensity", 1.0);
    Vec3 radiance;
    for (int k = 0; k < 3; ++k) {
        const double value = colour[static_cast<std::size_t>(k)] * intensity;
        radiance[k] = static_cast<float>(value);
        if (value < 0.0 || !std::isfinite(radiance[k])) {
            throw light.error(
                fmt::format("color times intensity: expected nothing negative or too "
                            "large for a float, found {}",
                            value));
        }
    }
    return radiance;
}

reference::SpotCone cone_of(const GltfObject& light) {
    const auto spot = light.object("spot");
    const double inner = spot ? spot->number("innerConeAngle", 0.0) : 0.0;
    const double outer = spot ? spot->number("outerConeAngle", 45.0 * kDegree) : 45.0 * kDegree;
    if (!(inner >= 0.0 && inner < outer && outer <= 90.001 * kDegree)) {
        throw light.error(
            fmt::format("spot: expected 0 <= innerConeAngle < outerConeAngle <= pi/2, "
                        "found {} and {}",
                        inner, outer));
    }
    // A cone that is too narrow for a float keeps some width.
    constexpr float kNarrowest = 0.999999f;
    const float cosine = std::min(static_cast<float>(std::cos(outer)), kNarrowest);
    return {std::max(static_cast<float>(std::cos(inner)), cosine), cosine};
}

}  // namespace

std::optional<Light> read_gltf_light(const GltfObject& light, const Affine& place, Notes& notes) {
    const std::string type = light.text("type", "");
    const Vec3 radiance = radiance_of(light);
    const Vec3 position = rounded(place.point({0, 0, 0}));
    if (type == "directional") {
        const Light out = directional_light(rounded(place.vector({0, 0, -1})), radiance);
        if (!reference::is_zero(out.normal)) return out;
        notes.add("a directional light without direction: left out");
        return std::nullopt;
    }
    if (type != "point" && type != "spot") {
        throw light.error(
            fmt::format("type: expected directional, point or spot, found '{}'", type));
    }
    if (light.has("range")) {
        notes.add("a light's range is not supported: it falls off with the squared distance only");
    }
    if (type == "point") return point_light(position, radiance);
    const Light out =
        spot_light(position, rounded(place.vector({0, 0, -1})), radiance, cone_of(light));
    if (!reference::is_zero(out.normal)) return out;
    notes.add("a spot light without direction: left out");
    return std::nullopt;
}

std::optional<Camera> read_gltf_camera(const GltfObject& camera, const Affine& place,
                                       Notes& notes) {
    const std::string type = camera.text("type", "");
    if (type != "perspective") {
        notes.add(fmt::format("a camera of the type '{}', not a perspective one: left out", type));
        return std::nullopt;
    }
    const auto perspective = camera.object("perspective");
    const double angle = perspective ? perspective->number("yfov", 0.0) : 0.0;
    if (!(angle > 0.0 && angle < 180.0 * kDegree)) {
        throw camera.error(
            fmt::format("yfov: expected more than 0 and less than pi radians, found {}", angle));
    }
    const Vec3 forward = rounded(unit(place.vector({0, 0, -1})));
    const Vec3 up = rounded(unit(place.vector({0, 1, 0})));
    if (!(reference::length(reference::cross(forward, up)) >= 1e-4f)) {
        notes.add("a camera whose transform leaves it no direction: left out");
        return std::nullopt;
    }
    if (place.determinant() < 0.0) {
        notes.add("a camera whose transform mirrors: the picture is not mirrored");
    }
    Camera out = look_at(Vec3(0.0f), forward, up, static_cast<float>(std::tan(0.5 * angle)));
    out.position = rounded(place.point({0, 0, 0}));
    return out;
}

}  // namespace scotty::scenes
