#include <cmath>

#include "scenes/built_in.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Scene;

namespace {

/// A wall of upright strips with shared edges whose widths grow from 4 micrometres, a hundredth at
/// a time: the first ones are 250,000 times taller than wide.
void add_graded_curtain(Scene& scene, std::uint32_t material) {
    constexpr double kWidth = 1.2;
    double x = 0.0;
    double step = 4e-6;
    std::uint32_t low = reference::kNone;
    while (x < kWidth) {
        const auto column = static_cast<float>(-1.3 + x);
        const auto depth = static_cast<float>(-0.6 + 0.15 * x);
        const std::uint32_t next_low = add_vertex(scene, Vec3(column, 0.9f, depth));
        const std::uint32_t next_high = add_vertex(scene, Vec3(column, 1.9f, depth));
        if (low != reference::kNone) {
            add_triangle(scene, low, next_low, next_high, material);
            add_triangle(scene, low, next_high, low + 1, material);
        }
        low = next_low;
        x += step;
        step *= 1.01;
    }
}

/// A flat cone of thin triangles that all share its tip.
void add_fan(Scene& scene, std::uint32_t material) {
    constexpr std::uint32_t kBlades = 1440;
    const std::uint32_t tip = add_vertex(scene, Vec3(0.7f, 1.35f, -0.2f));
    for (std::uint32_t i = 0; i < kBlades; ++i) {
        const double angle = 6.283185307179586 * i / kBlades;
        add_vertex(scene, Vec3(static_cast<float>(0.7 + 0.5 * std::cos(angle)),
                               static_cast<float>(1.35 + 0.5 * std::sin(angle)), -0.45f));
    }
    for (std::uint32_t i = 0; i < kBlades; ++i) {
        add_triangle(scene, tip, tip + 1 + i, tip + 1 + (i + 1) % kBlades, material);
    }
}

/// Single needles in space, 2 m long and 10 micrometres thick, in all directions.
void add_needles(Scene& scene, std::uint32_t material) {
    for (std::uint32_t i = 0; i < 64; ++i) {
        const double angle = 3.141592653589793 * (i + 0.5) / 64.0;
        const auto dx = static_cast<float>(std::cos(angle));
        const auto dy = static_cast<float>(std::sin(angle));
        const float z = 0.3f - 0.01f * static_cast<float>(i);
        const std::uint32_t a = add_vertex(scene, Vec3(-dx, 1.0f - dy, z));
        add_vertex(scene, Vec3(dx, 1.0f + dy, z - 0.2f));
        add_vertex(scene, Vec3(dx - 1e-5f * dy, 1.0f + dy + 1e-5f * dx, z - 0.2f));
        add_triangle(scene, a, a + 1, a + 2, material);
    }
}

/// The same square three times over in the same place: twice exactly, once with its vertices in
/// another order. Which one is seen is a matter of the tie rule alone.
void add_coincident_squares(Scene& scene) {
    const Vec3 corner(-1.0f, 0.15f, 0.2f);
    const Vec3 edge_x(0.6f, 0.0f, -0.1f);
    const Vec3 edge_y(0.0f, 0.6f, 0.0f);
    add_quad(scene, corner, edge_x, edge_y, add_diffuse(scene, Vec3(0.8f, 0.3f, 0.2f)));
    add_quad(scene, corner, edge_x, edge_y, add_diffuse(scene, Vec3(0.2f, 0.7f, 0.3f)));
    const std::uint32_t blue = add_diffuse(scene, Vec3(0.2f, 0.3f, 0.8f));
    const auto base = static_cast<std::uint32_t>(scene.vertices.size());
    for (const Vec3& offset : {edge_x, edge_x + edge_y, edge_y, Vec3(0, 0, 0)}) {
        add_vertex(scene, corner + offset);
    }
    add_triangle(scene, base + 1, base + 3, base, blue);
    add_triangle(scene, base + 2, base + 3, base + 1, blue);
}

/// Triangles with nothing inside: three equal points, two equal indices, three points in a row.
void add_zero_area(Scene& scene, std::uint32_t material) {
    const std::uint32_t a = add_vertex(scene, Vec3(0.0f, 0.5f, 0.5f));
    const std::uint32_t same = add_vertex(scene, Vec3(0.0f, 0.5f, 0.5f));
    const std::uint32_t b = add_vertex(scene, Vec3(0.5f, 0.5f, 0.5f));
    const std::uint32_t middle = add_vertex(scene, Vec3(0.25f, 0.5f, 0.5f));
    add_triangle(scene, a, same, a, material);
    add_triangle(scene, a, b, b, material);
    add_triangle(scene, a, b, middle, material);
    add_triangle(scene, same, a, b, material);
}

/// One triangle above, two below whose shared vertex lies on the upper one's edge, without being
/// its vertex: a seam through which rays may slip, in every tracer at the same place.
void add_t_junction(Scene& scene, std::uint32_t above, std::uint32_t below) {
    const std::uint32_t left = add_vertex(scene, Vec3(0.1f, 0.45f, 0.1f));
    const std::uint32_t right = add_vertex(scene, Vec3(1.2f, 0.38f, -0.1f));
    const std::uint32_t top = add_vertex(scene, Vec3(0.7f, 0.75f, 0.0f));
    const std::uint32_t bottom = add_vertex(scene, Vec3(0.6f, 0.05f, 0.1f));
    const std::uint32_t on_edge = add_vertex(
        scene, scene.vertices[left] + 0.37f * (scene.vertices[right] - scene.vertices[left]));
    add_triangle(scene, left, right, top, above);
    add_triangle(scene, left, bottom, on_edge, below);
    add_triangle(scene, on_edge, bottom, right, below);
}

Scene generate_slivers(const Parameters&) {
    Scene scene;
    const std::uint32_t grey = add_diffuse(scene, Vec3(0.6f, 0.6f, 0.6f));
    const std::uint32_t sand = add_diffuse(scene, Vec3(0.75f, 0.6f, 0.4f));
    const std::uint32_t teal = add_diffuse(scene, Vec3(0.2f, 0.6f, 0.6f));
    const std::uint32_t plum = add_diffuse(scene, Vec3(0.6f, 0.25f, 0.5f));
    add_quad(scene, Vec3(-3, 0, 3), Vec3(6, 0, 0), Vec3(0, 0, -6), grey);
    add_graded_curtain(scene, sand);
    add_fan(scene, teal);
    add_needles(scene, plum);
    add_coincident_squares(scene);
    add_zero_area(scene, plum);
    add_t_junction(scene, sand, teal);
    scene.lights.push_back(directional_light(Vec3(0.4f, -1.0f, -0.7f), Vec3(1.4f, 1.3f, 1.1f)));
    scene.lights.push_back(point_light(Vec3(0.9f, 0.8f, 1.3f), Vec3(0.8f, 0.8f, 1.0f)));
    scene.lights.push_back(environment_light(Vec3(0.25f, 0.3f, 0.4f)));
    scene.camera = look_at(Vec3(0, 1, 3.6f), Vec3(0, 0.95f, 0), Vec3(0, 1, 0), 0.4f);
    return scene;
}

}  // namespace

const Generator kSlivers = {"slivers",
                            "needles, fans, coincident and zero-area triangles under an open sky",
                            {},
                            generate_slivers};

}  // namespace scotty::scenes
