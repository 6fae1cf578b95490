#include "scenes/built_in.h"
#include "scenes/geodesic.h"
#include "scenes/material_mapping.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

namespace {

std::uint32_t add_metal(reference::Scene& scene, const Vec3& colour, float roughness) {
    Notes none;
    return add_material(scene, material_from_metallic_roughness(colour, 1.0f, roughness, none));
}

/// Sharp and wide lobes, an area light that both count once, and a point light, which no ray meets.
reference::Scene generate_metals(const Parameters& parameters) {
    reference::Scene scene = cornell_room();
    const std::uint32_t frequency = parameters.integer("frequency");
    const auto roughness = static_cast<float>(parameters.number("roughness"));
    // A millimetre above the floor, so that no vertex lies in it.
    add_sphere(scene, Vec3(-0.5f, 0.381f, -0.4f), 0.38f, frequency,
               add_metal(scene, Vec3(1.0f, 0.78f, 0.34f), roughness));
    add_sphere(scene, Vec3(0.48f, 0.381f, -0.1f), 0.38f, frequency,
               add_metal(scene, Vec3(0.95f, 0.64f, 0.54f), 0.15f));
    add_sphere(scene, Vec3(-0.1f, 0.281f, 0.55f), 0.28f, frequency,
               add_metal(scene, Vec3(0.56f, 0.57f, 0.58f), 0.8f));
    reference::Light point;
    point.kind = reference::LightKind::point;
    point.position = Vec3(0.2f, 1.2f, 0.9f);
    point.radiance = Vec3(0.6f, 0.6f, 0.8f);
    scene.lights.push_back(point);
    return scene;
}

}  // namespace

const Generator kMetals = {"metals",
                           "Cornell box with three spheres of rough metal and a point light",
                           {{"frequency", 12, 1, 1000}, {"roughness", 0.4, 0.002, 1, false}},
                           generate_metals};

}  // namespace scotty::scenes
