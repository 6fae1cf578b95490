#include "scenes/file_scene.h"

#include <algorithm>
#include <cmath>

#include "reference/base/error.h"
#include "scenes/affine.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Camera;
using reference::dot;
using reference::Light;
using reference::LightKind;
using reference::normalize_or;
using reference::Scene;

namespace {

/// How far off a light's plane a triangle may lie and still be its visible side, as a share of the
/// light's longer edge.
constexpr float kPlaneTolerance = 0.02f;

/// How much wider than the bounding box a fitted camera looks.
constexpr float kMargin = 1.05f;

constexpr float kPi = 3.14159265f;

/// Radiance of the default environment; the default directional light adds the rest to 1.
constexpr float kDefaultSky = 0.25f;

/// Whether `p` lies over the parallelogram, a twentieth beyond its edges allowed.
bool over(const Light& light, const Vec3& p) {
    const Vec3 offset = p - light.position;
    const Vec3 across = reference::cross(light.edge_x, light.edge_y);
    const float square = dot(across, across);
    const float x = dot(reference::cross(offset, light.edge_y), across) / square;
    const float y = dot(reference::cross(light.edge_x, offset), across) / square;
    return x > -0.05f && x < 1.05f && y > -0.05f && y < 1.05f;
}

/// Index of the area light that the triangle is the visible side of, kNone where there is none.
std::uint32_t light_of(const Scene& scene, const std::array<std::uint32_t, 3>& triangle) {
    const Vec3& a = scene.vertices[triangle[0]];
    const Vec3& b = scene.vertices[triangle[1]];
    const Vec3& c = scene.vertices[triangle[2]];
    for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (light.kind != LightKind::parallelogram) continue;
        const float tolerance = kPlaneTolerance * std::max(reference::length(light.edge_x),
                                                           reference::length(light.edge_y));
        const bool in_plane = std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) {
            return std::abs(dot(scene.vertices[v] - light.position, light.normal)) <= tolerance;
        });
        if (in_plane && over(light, (a + b + c) * (1.0f / 3.0f))) return i;
    }
    return reference::kNone;
}

Vec3 front_of(const Scene& scene, const std::array<std::uint32_t, 3>& triangle) {
    const Vec3& a = scene.vertices[triangle[0]];
    return normalize_or(
        reference::cross(scene.vertices[triangle[1]] - a, scene.vertices[triangle[2]] - a),
        Vec3(0.0f));
}

/// Turns a triangle over; its vertices become flat copies, because shared normals would be wrong.
void turn_over(Scene& scene, std::array<std::uint32_t, 3>& triangle) {
    std::swap(triangle[1], triangle[2]);
    for (std::uint32_t& vertex : triangle) {
        const Vec3 position = scene.vertices[vertex];
        vertex = add_vertex(scene, position);
    }
}

/// Moves a light forward to the foremost of its visible triangles, which would shadow it.
bool bring_in_front(Light& light, const Scene& scene, const std::vector<std::uint32_t>& own) {
    float foremost = 0.0f;
    for (const std::uint32_t t : own) {
        for (const std::uint32_t v : scene.triangles[t]) {
            foremost = std::max(foremost, dot(scene.vertices[v] - light.position, light.normal));
        }
    }
    light.position += light.normal * foremost;
    const float size = std::max(reference::length(light.edge_x), reference::length(light.edge_y));
    return foremost > 1e-6f * std::max(size, reference::max_abs(light.position));
}

/// Gives the triangles a copy of their material that is marked as sampled.
class SampledCopies {
 public:
    explicit SampledCopies(Scene& scene) : scene_(scene), copy_(scene.materials.size(), kNone) {}

    void mark(std::uint32_t triangle) {
        std::uint32_t& material = scene_.material_of[triangle];
        std::uint32_t& copy = copy_[material];
        if (copy == kNone) {
            reference::Material sampled = scene_.materials[material];
            sampled.emission_is_sampled = 1;
            copy = add_material(scene_, sampled);
        }
        material = copy;
    }

 private:
    static constexpr std::uint32_t kNone = reference::kNone;
    Scene& scene_;
    std::vector<std::uint32_t> copy_;
};

/// Drops the materials that no triangle uses.
void drop_unused_materials(Scene& scene) {
    std::vector<std::uint32_t> place(scene.materials.size(), reference::kNone);
    for (const std::uint32_t material : scene.material_of) place[material] = 0;
    std::vector<reference::Material> kept;
    for (std::size_t i = 0; i < place.size(); ++i) {
        if (place[i] == reference::kNone) continue;
        place[i] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(scene.materials[i]);
    }
    for (std::uint32_t& material : scene.material_of) material = place[material];
    scene.materials = std::move(kept);
}

}  // namespace

std::uint32_t add_default_material(Scene& scene) {
    return add_diffuse(scene, Vec3(kDefaultReflectance));
}

void settle_emission(Scene& scene, Notes& notes) {
    const std::size_t file_lights = scene.lights.size();
    std::vector<std::vector<std::uint32_t>> visible_side(file_lights);
    std::vector<std::uint32_t> others;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        if (reference::is_zero(scene.materials[scene.material_of[t]].emission)) continue;
        const std::uint32_t light = light_of(scene, scene.triangles[t]);
        (light == reference::kNone ? others : visible_side[light]).push_back(t);
    }
    SampledCopies copies(scene);
    for (std::size_t i = 0; i < file_lights; ++i) {
        Light& light = scene.lights[i];
        bool differs = false;
        for (const std::uint32_t t : visible_side[i]) {
            if (dot(front_of(scene, scene.triangles[t]), light.normal) < 0.0f) {
                turn_over(scene, scene.triangles[t]);
                notes.add("an emissive triangle in an area light faced away from it: turned over");
            }
            differs |= scene.materials[scene.material_of[t]].emission != light.radiance;
            copies.mark(t);
        }
        if (differs) {
            notes.add(
                "an area light's radiance is not that of the emissive mesh in it: the one "
                "lights the scene, the other is seen");
        }
        if (bring_in_front(light, scene, visible_side[i])) {
            notes.add("an area light lay behind the emissive mesh in it: moved to its front");
        }
    }
    if (others.size() > kMaxTriangleLights) {
        notes.add(
            fmt::format("{} emissive triangles are too many for a light each (at most {}): "
                        "paths must find them, expect noise",
                        others.size(), kMaxTriangleLights));
    } else {
        for (const std::uint32_t t : others) {
            const auto& [a, b, c] = scene.triangles[t];
            const Light light =
                triangle_light(scene.vertices[a], scene.vertices[b], scene.vertices[c],
                               scene.materials[scene.material_of[t]].emission);
            if (!(light.area > 0.0f)) continue;
            scene.lights.push_back(light);
            copies.mark(t);
        }
    }
    drop_unused_materials(scene);
}

void add_default_lights(Scene& scene, Notes& notes) {
    if (!scene.lights.empty()) return;
    for (const auto& material : scene.materials) {
        if (!reference::is_zero(material.emission)) return;
    }
    const Camera& camera = scene.camera;
    const Vec3 direction = camera.forward - camera.up * 0.8f + camera.right * 0.5f;
    scene.lights.push_back(directional_light(direction, Vec3(kPi * (1.0f - kDefaultSky))));
    scene.lights.push_back(environment_light(Vec3(kDefaultSky)));
    notes.add(
        "no light in the file: a directional light from above the camera and a dim sky were added "
        "(#lights=none leaves it dark)");
}

Camera fit_camera(const Scene& scene, const Camera& direction_of) {
    const reference::Bounds box = reference::bounds_of(scene);
    const Vec3 centre = box.low * 0.5f + box.high * 0.5f;
    const float half_height = direction_of.tan_half_width > 0.0f ? direction_of.tan_half_width
                                                                 : direction_of.tan_half_fov;
    const float tangent = half_height / kMargin;
    float distance = 0.0f;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Vec3 offset =
            Vec3(corner & 1u ? box.high.x : box.low.x, corner & 2u ? box.high.y : box.low.y,
                 corner & 4u ? box.high.z : box.low.z) -
            centre;
        const float aside = std::max(std::abs(dot(offset, direction_of.right)),
                                     std::abs(dot(offset, direction_of.up)));
        distance = std::max(distance, aside / tangent - dot(offset, direction_of.forward));
    }
    // A scene that is a single point is looked at from somewhere.
    if (!(distance > 0.0f)) distance = std::max(1e-3f * reference::max_abs(centre), 1e-3f);
    Camera camera = direction_of;
    // Whatever the picture's shape, its height has to hold the scene.
    camera.tan_half_fov = half_height;
    camera.tan_half_width = 0.0f;
    camera.position = centre - camera.forward * distance;
    return camera;
}

void settle_camera(Scene& scene, const std::vector<Viewpoint>& viewpoints, CameraChoice choice,
                   Notes& notes) {
    const bool has_own = !viewpoints.empty();
    if (viewpoints.size() > 1) {
        notes.add(
            fmt::format("a further camera: the first one is used; #camera=NAME takes another: {}",
                        names_of(viewpoints)),
            viewpoints.size() - 1);
    }
    if (has_own && choice != CameraChoice::fit) {
        scene.camera = viewpoints.front().camera;
        return;
    }
    if (choice == CameraChoice::file) {
        throw reference::Error::bad_input(
            scene.name,
            "has no camera, and #camera=file asks for the file's own; without it one is "
            "placed that frames the whole scene");
    }
    // From the front, a little from above and the right.
    const Camera standard =
        look_at(Vec3(0.35f, 0.3f, 1.0f), Vec3(0.0f, 0.0f, 0.0f), Vec3(0.0f, 1.0f, 0.0f), 0.4f);
    scene.camera = fit_camera(scene, has_own ? viewpoints.front().camera : standard);
    if (!has_own) notes.add("no camera in the file: one was placed that frames the whole scene");
}

}  // namespace scotty::scenes
