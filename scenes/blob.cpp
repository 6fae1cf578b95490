#include <fmt/format.h>

#include "reference/base/memory.h"
#include "scenes/built_in.h"
#include "scenes/geodesic.h"
#include "scenes/mesh.h"
#include "scenes/noise.h"

namespace scotty::scenes {

namespace {

constexpr double kRadius = 0.62;
constexpr double kRoughness = 0.3;

/// Distance from the blob's centre; octaves down to a detail that only fine meshes show.
double radius_towards(const Direction& d) {
    double height = 0.0;
    double amplitude = 0.5;
    double scale = 2.0;
    for (std::uint32_t octave = 0; octave < 5; ++octave) {
        height += amplitude * value_noise(d[0] * scale, d[1] * scale, d[2] * scale, octave);
        amplitude *= 0.5;
        scale *= 2.0;
    }
    return kRadius * (1.0 + kRoughness * height);
}

reference::Scene generate_blob(const Parameters& parameters) {
    const double asked = parameters.number("triangles");
    const std::uint32_t frequency = geodesic_frequency(asked);
    const std::uint64_t made = geodesic_triangles(frequency);
    reference::require_memory(made * 240, fmt::format("a blob of {} triangles with its BVH", made),
                              "blob:triangles=N takes fewer");

    reference::Scene scene = cornell_room();
    const std::uint32_t clay = add_diffuse(scene, Vec3(0.55f, 0.5f, 0.75f));
    const std::size_t first_vertex = scene.vertices.size();
    const std::size_t first_triangle = scene.triangles.size();
    add_geodesic(scene, frequency, clay, [](const Direction& d) {
        const double radius = radius_towards(d);
        return Vec3(static_cast<float>(d[0] * radius), static_cast<float>(0.85 + d[1] * radius),
                    static_cast<float>(d[2] * radius));
    });
    smooth_normals(scene, first_vertex, first_triangle);
    if (static_cast<double>(made) != asked) {
        scene.warnings.push_back(fmt::format(
            "blob: {:.0f} triangles asked for, {} made (20 n^2, the next size up)", asked, made));
    }
    return scene;
}

}  // namespace

const Generator kBlob = {"blob",
                         "Cornell box with a displaced sphere of any resolution",
                         {{"triangles", 20480, 20, kMaxTriangles}},
                         generate_blob};

}  // namespace scotty::scenes
