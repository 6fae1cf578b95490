#include "reference/contract/scene.h"

namespace scotty::reference {

SceneView view_of(const Scene& scene) {
    SceneView view;
    view.vertices = scene.vertices.data();
    view.normals = scene.normals.empty() ? nullptr : scene.normals.data();
    view.triangles = scene.triangles.empty() ? nullptr : scene.triangles.front().data();
    view.material_of = scene.material_of.data();
    view.materials = scene.materials.data();
    view.lights = scene.lights.data();
    view.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    view.light_count = static_cast<std::uint32_t>(scene.lights.size());
    for (const Light& light : scene.lights) {
        if (light.kind == LightKind::environment) view.environment += light.radiance;
        if (light.kind == LightKind::hemisphere) {
            view.hemisphere += light.radiance;
            view.hemisphere_up = light.normal;
        }
    }
    view.camera = scene.camera;
    return view;
}

Bounds bounds_of(const Scene& scene) {
    Bounds bounds;
    for (const auto& triangle : scene.triangles) {
        for (const std::uint32_t vertex : triangle) {
            bounds.low = min_of(bounds.low, scene.vertices[vertex]);
            bounds.high = max_of(bounds.high, scene.vertices[vertex]);
        }
    }
    return bounds;
}

}  // namespace scotty::reference
