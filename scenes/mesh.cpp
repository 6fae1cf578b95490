#include "scenes/mesh.h"

#include <algorithm>

#include "reference/base/error.h"

namespace scotty::scenes {

using reference::cross;
using reference::Light;
using reference::LightKind;
using reference::Material;
using reference::MaterialKind;
using reference::normalize_or;
using reference::Scene;

namespace {

Light area_light(LightKind kind, const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
                 const Vec3& radiance) {
    const Vec3 area = cross(edge_x, edge_y);
    Light light;
    light.kind = kind;
    light.position = corner;
    light.edge_x = edge_x;
    light.edge_y = edge_y;
    light.normal = normalize_or(area, Vec3(0.0f));
    light.radiance = radiance;
    light.area = reference::length(area) * (kind == LightKind::triangle ? 0.5f : 1.0f);
    return light;
}

}  // namespace

std::uint32_t add_material(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

std::uint32_t add_diffuse(Scene& scene, const Vec3& albedo) {
    Material material;
    material.reflectance = albedo;
    return add_material(scene, material);
}

std::uint32_t add_mirror(Scene& scene, const Vec3& reflectance) {
    Material material;
    material.kind = MaterialKind::mirror;
    material.reflectance = reflectance;
    return add_material(scene, material);
}

std::uint32_t add_glass(Scene& scene, const Vec3& tint, float ior) {
    Material material;
    material.kind = MaterialKind::glass;
    material.reflectance = tint;
    material.transmittance = tint;
    material.ior = ior;
    return add_material(scene, material);
}

std::uint32_t add_vertex(Scene& scene, const Vec3& position, const Vec3& normal) {
    scene.vertices.push_back(position);
    scene.normals.push_back(normal);
    return static_cast<std::uint32_t>(scene.vertices.size() - 1);
}

void add_triangle(Scene& scene, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                  std::uint32_t material) {
    scene.triangles.push_back({a, b, c});
    scene.material_of.push_back(material);
}

void add_quad(Scene& scene, const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
              std::uint32_t material) {
    const std::uint32_t a = add_vertex(scene, corner);
    const std::uint32_t b = add_vertex(scene, corner + edge_x);
    const std::uint32_t c = add_vertex(scene, corner + edge_x + edge_y);
    const std::uint32_t d = add_vertex(scene, corner + edge_y);
    add_triangle(scene, a, b, c, material);
    add_triangle(scene, a, c, d, material);
}

Light parallelogram_light(const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
                          const Vec3& radiance) {
    return area_light(LightKind::parallelogram, corner, edge_x, edge_y, radiance);
}

Light triangle_light(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& radiance) {
    return area_light(LightKind::triangle, a, b - a, c - a, radiance);
}

Light point_light(const Vec3& position, const Vec3& intensity) {
    Light light;
    light.kind = LightKind::point;
    light.position = position;
    light.radiance = intensity;
    return light;
}

Light spot_light(const Vec3& position, const Vec3& direction, const Vec3& intensity,
                 const reference::SpotCone& cone) {
    Light light = point_light(position, intensity);
    light.kind = LightKind::spot;
    light.normal = normalize_or(direction, Vec3(0.0f));
    reference::set_spot_cone(light, cone);
    return light;
}

Light directional_light(const Vec3& direction, const Vec3& irradiance) {
    Light light;
    light.kind = LightKind::directional;
    light.normal = normalize_or(direction, Vec3(0.0f));
    light.radiance = irradiance;
    return light;
}

Light environment_light(const Vec3& radiance) {
    Light light;
    light.kind = LightKind::environment;
    light.radiance = radiance;
    return light;
}

Light hemisphere_light(const Vec3& radiance) {
    Light light;
    light.kind = LightKind::hemisphere;
    light.normal = Vec3(0.0f, 1.0f, 0.0f);
    light.radiance = radiance;
    return light;
}

void add_lamp(Scene& scene, const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
              const Vec3& radiance) {
    Material material;
    material.emission = radiance;
    material.emission_is_sampled = 1;
    add_quad(scene, corner, edge_x, edge_y, add_material(scene, material));
    scene.lights.push_back(parallelogram_light(corner, edge_x, edge_y, radiance));
}

void smooth_normals(Scene& scene, std::size_t first_vertex, std::size_t first_triangle) {
    for (std::size_t i = first_triangle; i < scene.triangles.size(); ++i) {
        const auto& [a, b, c] = scene.triangles[i];
        const Vec3 doubled_area =
            cross(scene.vertices[b] - scene.vertices[a], scene.vertices[c] - scene.vertices[a]);
        for (const std::uint32_t vertex : {a, b, c}) scene.normals[vertex] += doubled_area;
    }
    for (std::size_t i = first_vertex; i < scene.normals.size(); ++i) {
        scene.normals[i] = normalize_or(scene.normals[i], Vec3(0.0f));
    }
}

void finish_normals(Scene& scene) {
    if (std::all_of(scene.normals.begin(), scene.normals.end(), reference::is_zero)) {
        scene.normals.clear();
        scene.normals.shrink_to_fit();
    }
}

reference::Camera look_at(const Vec3& position, const Vec3& target, const Vec3& up,
                          float tan_half_fov) {
    reference::Camera camera;
    camera.position = position;
    camera.forward = normalize_or(target - position, Vec3(0.0f));
    camera.right = normalize_or(cross(camera.forward, up), Vec3(0.0f));
    camera.up = cross(camera.right, camera.forward);
    camera.tan_half_fov = tan_half_fov;
    if (reference::is_zero(camera.right)) {
        throw reference::Error::internal("look_at: position, target and up give no direction");
    }
    return camera;
}

}  // namespace scotty::scenes
