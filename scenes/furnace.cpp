#include "scenes/built_in.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

namespace {

/// In equilibrium the radiance is emission / (1 - albedo) everywhere; n bounces of light give
/// emission * (1 - albedo^(n + 1)) / (1 - albedo).
reference::Scene generate_furnace(const Parameters& parameters) {
    reference::Scene scene;
    const auto albedo = static_cast<float>(parameters.number("albedo"));
    const auto emission = static_cast<float>(parameters.number("emission"));
    reference::Material wall;
    wall.reflectance = Vec3(albedo, albedo, albedo);
    wall.emission = Vec3(emission, emission, emission);
    wall.emission_is_sampled = 0;  // no light stands for it: paths find it themselves
    const std::uint32_t material = add_material(scene, wall);
    // Eight shared corners: bit 0 is x, bit 1 is y, bit 2 is z.
    for (std::uint32_t i = 0; i < 8; ++i) {
        add_vertex(scene, Vec3(i & 1u ? 1 : -1, i & 2u ? 2 : 0, i & 4u ? 1 : -1));
    }
    const auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        add_triangle(scene, a, b, c, material);
        add_triangle(scene, a, c, d, material);
    };
    face(4, 5, 1, 0);  // floor
    face(2, 3, 7, 6);  // ceiling
    face(0, 1, 3, 2);  // back
    face(5, 4, 6, 7);  // front
    face(4, 0, 2, 6);  // left
    face(1, 5, 7, 3);  // right
    scene.camera = look_at(Vec3(0.2f, 0.9f, 0.6f), Vec3(-0.1f, 1.1f, -0.4f), Vec3(0, 1, 0), 0.6f);
    return scene;
}

}  // namespace

const Generator kFurnace = {"furnace",
                            "closed box that glows evenly: radiance is emission / (1 - albedo)",
                            {{"albedo", 0.5, 0, 0.999, false}, {"emission", 0.5, 0, 1e6, false}},
                            generate_furnace};

}  // namespace scotty::scenes
