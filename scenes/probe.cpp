#include "scenes/probe.h"

#include <array>
#include <cmath>

#include "scenes/built_in.h"
#include "scenes/mesh.h"
#include "scenes/noise.h"

namespace scotty::scenes {

using reference::Scene;

namespace {

std::uint32_t add_conductor(Scene& scene, const Vec3& colour, float roughness) {
    reference::Material material;
    material.kind = reference::MaterialKind::conductor;
    material.reflectance = colour;
    material.ior = roughness;
    return add_material(scene, material);
}

/// What stands in front of the camera: diffuse of two colours, a mirror, glass, and metals whose
/// lobe is wide and sharp.
struct ProbeMaterials {
    std::array<std::uint32_t, 6> all;

    explicit ProbeMaterials(Scene& scene)
        : all{add_diffuse(scene, Vec3(0.7f, 0.6f, 0.5f)),
              add_diffuse(scene, Vec3(0.2f, 0.5f, 0.9f)),
              add_mirror(scene, Vec3(0.9f, 0.85f, 0.8f)),
              add_glass(scene, Vec3(0.95f, 0.9f, 1.0f), 1.45f),
              add_conductor(scene, Vec3(1.0f, 0.8f, 0.4f), 0.6f),
              add_conductor(scene, Vec3(0.6f, 0.7f, 0.8f), 0.1f)} {}
    std::uint32_t of(std::uint32_t i) const { return all[i % all.size()]; }
};

/// In [0, 1).
float unit(std::uint32_t i, std::uint32_t use) {
    return static_cast<float>(0.4999 + 0.4999 * signed_hash(i, use));
}

void add_one_triangle(Scene& scene, const ProbeMaterials& materials) {
    const std::uint32_t a = add_vertex(scene, Vec3(-0.9f, 0.1f, 0.1f));
    add_vertex(scene, Vec3(0.9f, 0.2f, -0.2f));
    add_vertex(scene, Vec3(0.1f, 1.9f, -0.1f));
    add_triangle(scene, a, a + 1, a + 2, materials.of(0));
}

/// A floor, two walls and bent quads with smooth normals, one of each material.
void add_corner(Scene& scene, const ProbeMaterials& materials) {
    add_quad(scene, Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2), materials.of(0));
    add_quad(scene, Vec3(-1, 0, -1), Vec3(2, 0, 0), Vec3(0, 2, 0), materials.of(1));
    add_quad(scene, Vec3(-1, 0, 1), Vec3(0, 0, -2), Vec3(0, 2, 0), materials.of(0));
    for (std::uint32_t i = 0; i < 5; ++i) {
        const float x = -0.7f + 0.35f * static_cast<float>(i);
        const std::size_t vertex = scene.vertices.size();
        const std::size_t triangle = scene.triangles.size();
        const std::uint32_t a = add_vertex(scene, Vec3(x - 0.15f, 0.2f, 0.2f));
        add_vertex(scene, Vec3(x + 0.15f, 0.2f, 0.2f));
        add_vertex(scene, Vec3(x + 0.15f, 0.7f, -0.1f));
        add_vertex(scene, Vec3(x - 0.15f, 0.8f, 0.1f));
        add_triangle(scene, a, a + 1, a + 2, materials.of(i + 1));
        add_triangle(scene, a, a + 2, a + 3, materials.of(i + 1));
        smooth_normals(scene, vertex, triangle);
    }
}

/// Two places with far more triangles in one spot than a block loads of a leaf at a time: no
/// builder can part them. The lowest number counts, and they differ in material.
void add_coincident(Scene& scene, const ProbeMaterials& materials) {
    add_quad(scene, Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2), materials.of(0));
    for (const auto& [x, count] : {std::pair{-0.5f, 65u}, std::pair{0.5f, 150u}}) {
        for (std::uint32_t i = 0; i < count; ++i) {
            // The last fills the same box the other way round: some rays hit it and no other.
            const bool last = i + 1 == count;
            const std::uint32_t a =
                add_vertex(scene, last ? Vec3(x + 0.4f, 1.7f, 0.0f) : Vec3(x - 0.4f, 0.3f, 0.0f));
            add_vertex(scene, last ? Vec3(x - 0.4f, 1.6f, -0.1f) : Vec3(x + 0.4f, 0.4f, 0.1f));
            add_vertex(scene, last ? Vec3(x, 0.3f, 0.1f) : Vec3(x, 1.7f, -0.1f));
            add_triangle(scene, a, a + 1, a + 2, materials.of(i + count));
        }
    }
    const std::uint32_t a = add_vertex(scene, Vec3(-0.9f, 0.3f, 0.0f));
    add_vertex(scene, Vec3(0.9f, 0.4f, 0.1f));
    add_vertex(scene, Vec3(0.0f, 1.9f, -0.1f));
    add_triangle(scene, a, a + 1, a + 2, materials.of(1));
}

/// A ray through the middle meets all of them, from back to front in the order of their numbers.
void add_sheets(Scene& scene, const ProbeMaterials& materials) {
    for (std::uint32_t i = 0; i < 24; ++i) {
        const float z = -0.6f + 0.05f * static_cast<float>(i);
        const float half = 0.9f - 0.02f * static_cast<float>(i);
        add_quad(scene, Vec3(-half, 1.0f - half, z), Vec3(2 * half, 0, 0.01f),
                 Vec3(0, 2 * half, -0.02f), materials.of(i == 23 ? 3 : 0));
    }
}

/// Triangles of all sizes, in all directions: slivers, points, lines and some that are huge.
void add_soup(Scene& scene, const ProbeMaterials& materials) {
    for (std::uint32_t i = 0; i < 160; ++i) {
        const Vec3 centre(2 * unit(i, 1) - 1, 2 * unit(i, 2), 1.2f * unit(i, 3) - 1.0f);
        const float size = i % 40 == 7 ? 3.0f : std::exp2(-7.0f * unit(i, 4));
        const auto corner = [&](std::uint32_t k) {
            return centre + size * Vec3(unit(i, 3 * k + 5) - 0.5f, unit(i, 3 * k + 6) - 0.5f,
                                        unit(i, 3 * k + 7) - 0.5f);
        };
        const Vec3 b = corner(1);
        const std::uint32_t a = add_vertex(scene, corner(0));
        add_vertex(scene, b);
        add_vertex(scene, i % 20 == 3 ? b : i % 20 == 4 ? b + 1e-6f * centre : corner(2));
        add_triangle(scene, a, a + 1, a + 2, materials.of(i));
    }
}

/// A wavy sheet of shared edges, `side` squares along each.
void add_sheet(Scene& scene, const ProbeMaterials& materials, std::uint32_t side) {
    const auto first = static_cast<std::uint32_t>(scene.vertices.size());
    const float step = 2.2f / static_cast<float>(side);
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            add_vertex(scene, Vec3(-1.1f + step * static_cast<float>(x),
                                   -0.1f + step * static_cast<float>(y),
                                   0.1f * unit(y * (side + 1) + x, 1)));
        }
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t a = first + y * (side + 1) + x;
            add_triangle(scene, a, a + 1, a + side + 2, materials.of(x / 4));
            add_triangle(scene, a, a + side + 2, a + side + 1, materials.of(y / 4));
        }
    }
}

using AddGeometry = void (*)(Scene&, const ProbeMaterials&);
struct Geometry {
    const char* name;
    AddGeometry add;
};

constexpr std::size_t kField = 6;

const std::array<Geometry, 7>& geometries() {
    static const std::array<Geometry, 7> table{
        {{"one triangle", add_one_triangle},
         {"corner", add_corner},
         {"coincident", add_coincident},
         {"sheets", add_sheets},
         {"soup", add_soup},
         {"grid",
          [](Scene& scene, const ProbeMaterials& materials) { add_sheet(scene, materials, 24); }},
         {"field", [](Scene& scene, const ProbeMaterials& materials) {
              add_sheet(scene, materials, 256);
          }}}};
    return table;
}

using AddLights = void (*)(Scene&);
struct Lights {
    const char* name;
    AddLights add;
};

/// A fan of triangle lights over a regular polygon that faces the scene, and what glows there.
void add_polygon_light(Scene& scene, std::uint32_t corners) {
    reference::Material glow;
    glow.emission = Vec3(5, 6, 7);
    glow.emission_is_sampled = 1;
    const std::uint32_t material = add_material(scene, glow);
    const auto corner = [&](std::uint32_t i) {
        const double angle = 6.283185307179586 * i / corners;
        return Vec3(static_cast<float>(0.7 * std::sin(angle)), 2.2f,
                    static_cast<float>(0.6 + 0.7 * std::cos(angle)));
    };
    const Vec3 middle(0.0f, 2.2f, 0.6f);
    for (std::uint32_t i = 0; i < corners; ++i) {
        const std::uint32_t a = add_vertex(scene, middle);
        add_vertex(scene, corner(i + 1));
        add_vertex(scene, corner(i));
        add_triangle(scene, a, a + 1, a + 2, material);
        scene.lights.push_back(triangle_light(middle, corner(i + 1), corner(i), glow.emission));
    }
}

void add_triangle_light(Scene& scene) {
    scene.lights.push_back(triangle_light(Vec3(-0.8f, 2.3f, 0.2f), Vec3(0.7f, 2.4f, 0.3f),
                                          Vec3(0, 2.2f, 1.4f), Vec3(9, 8, 7)));
}
void add_quad_light(Scene& scene) {
    add_lamp(scene, Vec3(-0.4f, 2.2f, 0.1f), Vec3(0.8f, 0, 0), Vec3(0, 0, 0.9f), Vec3(8, 8, 9));
}
void add_point(Scene& scene) {
    scene.lights.push_back(point_light(Vec3(0.4f, 1.8f, 1.9f), Vec3(6, 5, 4)));
}
void add_directional(Scene& scene) {
    scene.lights.push_back(directional_light(Vec3(0.4f, -0.7f, -0.9f), Vec3(1.5f, 1.4f, 1.3f)));
}
void add_spot(Scene& scene) {
    scene.lights.push_back(spot_light(Vec3(0.3f, 2.0f, 2.2f), Vec3(-0.2f, -0.6f, -1.3f),
                                      Vec3(9, 10, 9), {0.97f, 0.8f}));
}
void add_environment(Scene& scene) {
    scene.lights.push_back(environment_light(Vec3(0.4f, 0.5f, 0.7f)));
}
void add_hemisphere(Scene& scene) {
    scene.lights.push_back(hemisphere_light(Vec3(0.7f, 0.6f, 0.5f)));
}
/// Something that glows and that no light stands for: only paths that hit it see it.
void add_glow(Scene& scene) {
    reference::Material glow;
    glow.reflectance = Vec3(0.3f, 0.3f, 0.3f);
    glow.emission = Vec3(2, 3, 4);
    add_quad(scene, Vec3(-1.0f, 1.6f, 0.4f), Vec3(2.0f, 0, 0), Vec3(0, 0.3f, -1.0f),
             add_material(scene, glow));
}
void add_all(Scene& scene) {
    add_quad_light(scene);
    add_triangle_light(scene);
    add_point(scene);
    add_directional(scene);
    add_spot(scene);
    add_environment(scene);
    add_hemisphere(scene);
    add_glow(scene);
}

const std::array<Lights, 11>& lights() {
    static const std::array<Lights, 11> table{
        {{"no light", [](Scene&) {}},
         {"a triangle light", add_triangle_light},
         {"a parallelogram light", add_quad_light},
         {"a polygon light", [](Scene& scene) { add_polygon_light(scene, 5); }},
         {"a point light", add_point},
         {"a directional light", add_directional},
         {"a spot light", add_spot},
         {"an environment", add_environment},
         {"a hemisphere", add_hemisphere},
         {"a glow", add_glow},
         {"all lights", add_all}}};
    return table;
}

using MakeCamera = reference::Camera (*)();
struct ProbeCamera {
    const char* name;
    MakeCamera make;
};

const std::array<ProbeCamera, 3>& cameras() {
    static const Vec3 target(0, 1, 0);
    static const std::array<ProbeCamera, 3> table{
        {{"upright", [] { return look_at(Vec3(0.1f, 1.1f, 3.6f), target, Vec3(0, 1, 0), 0.4f); }},
         {"horizontal field of view",
          [] {
              auto camera = look_at(Vec3(-0.3f, 1.4f, 3.4f), target, Vec3(0, 1, 0), 0.7f);
              camera.tan_half_width = 0.35f;
              return camera;
          }},
         {"rolled",
          [] { return look_at(Vec3(1.6f, 1.9f, 2.6f), target, Vec3(0.6f, 1, -0.2f), 0.45f); }}}};
    return table;
}

template <class Table>
std::vector<std::string> names_of(const Table& table) {
    std::vector<std::string> names;
    names.reserve(table.size());
    for (const auto& row : table) names.emplace_back(row.name);
    return names;
}

Scene generate_probe(const Parameters& parameters) {
    Scene scene;
    const ProbeMaterials materials(scene);
    geometries()[parameters.integer("geometry")].add(scene, materials);
    lights()[parameters.integer("lights")].add(scene);
    scene.camera = cameras()[parameters.integer("camera")].make();
    return scene;
}

}  // namespace

const std::vector<std::string>& probe_geometries() {
    static const std::vector<std::string> names = names_of(geometries());
    return names;
}

std::size_t probe_field() { return kField; }

const std::vector<std::string>& probe_lights() {
    static const std::vector<std::string> names = names_of(lights());
    return names;
}

const std::vector<std::string>& probe_cameras() {
    static const std::vector<std::string> names = names_of(cameras());
    return names;
}

const Generator kProbe = {
    "probe",
    "small scenes of chosen geometry and lights, for verification",
    {{"geometry", 1, 0, static_cast<double>(kField)}, {"lights", 10, 0, 10}, {"camera", 0, 0, 2}},
    generate_probe};

}  // namespace scotty::scenes
