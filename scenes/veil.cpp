#include "scenes/built_in.h"
#include "scenes/mesh.h"
#include "scenes/noise.h"

namespace scotty::scenes {

namespace {

constexpr float kFront = 0.6f;
constexpr float kBack = -0.7f;

/// A stack of sheets, small in front and large at the back, so that all of them show and a ray
/// through the middle meets every one. Tilts make their boxes, and some sheets, overlap.
reference::Scene generate_veil(const Parameters& parameters) {
    reference::Scene scene;
    const std::uint32_t layers = parameters.integer("layers");
    const std::uint32_t white = add_diffuse(scene, Vec3(0.73f, 0.73f, 0.73f));
    add_quad(scene, Vec3(-1.4f, -0.2f, -1), Vec3(2.8f, 0, 0), Vec3(0, 2.4f, 0), white);
    add_quad(scene, Vec3(-1.4f, -0.2f, 1), Vec3(2.8f, 0, 0), Vec3(0, 0, -2), white);
    for (std::uint32_t i = 0; i < layers; ++i) {
        const float depth = (static_cast<float>(i) + 0.5f) / static_cast<float>(layers);
        const auto jitter = [i](std::uint32_t use) {
            return static_cast<float>(signed_hash(i, use));
        };
        const float half = 0.35f + 0.55f * depth;
        const Vec3 centre(0.02f * jitter(1), 1.0f + 0.02f * jitter(2),
                          kFront + (kBack - kFront) * depth);
        const Vec3 edge_x(half, 0.03f * jitter(3), 0.04f * jitter(4));
        const Vec3 edge_y(0.03f * jitter(5), half, 0.04f * jitter(6));
        const Vec3 tint(0.3f + 0.5f * depth, 0.45f, 0.8f - 0.5f * depth);
        add_quad(scene, centre - edge_x - edge_y, 2.0f * edge_x, 2.0f * edge_y,
                 add_diffuse(scene, tint));
    }
    scene.lights.push_back(point_light(Vec3(-0.9f, 1.9f, 2.2f), Vec3(9, 9, 8)));
    // Steep from the side: its shadow rays pass the edges of many sheets.
    scene.lights.push_back(directional_light(Vec3(-1.0f, -0.6f, -0.5f), Vec3(1, 1.1f, 1.3f)));
    scene.camera = look_at(Vec3(0, 1, 3.6f), Vec3(0, 1, 0), Vec3(0, 1, 0), 0.4f);
    return scene;
}

}  // namespace

const Generator kVeil = {"veil",
                         "a stack of overlapping sheets: a ray meets all of them",
                         {{"layers", 64, 1, 1e6}},
                         generate_veil};

}  // namespace scotty::scenes
