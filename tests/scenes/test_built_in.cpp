
#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"

using namespace scotty;
using reference::Light;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using scenes::load_scene;

namespace {

std::uint32_t material_of_kind(const Scene& scene, MaterialKind kind) {
    for (std::uint32_t i = 0; i < scene.materials.size(); ++i) {
        if (scene.materials[i].kind == kind) return i;
    }
    FAIL("no material of this kind");
    return 0;
}

std::size_t lights_of_kind(const Scene& scene, LightKind kind) {
    std::size_t count = 0;
    for (const Light& light : scene.lights) count += light.kind == kind ? 1u : 0u;
    return count;
}

/// Whether the line from `origin` along `direction` passes through the triangle (any side).
bool meets(const Scene& scene, std::size_t triangle, const Vec3& origin, const Vec3& direction) {
    const auto& [ia, ib, ic] = scene.triangles[triangle];
    const Vec3 a = scene.vertices[ia] - origin;
    const Vec3 b = scene.vertices[ib] - origin;
    const Vec3 c = scene.vertices[ic] - origin;
    const float u = reference::dot(direction, reference::cross(c, b));
    const float v = reference::dot(direction, reference::cross(a, c));
    const float w = reference::dot(direction, reference::cross(b, a));
    return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

}  // namespace

TEST_CASE("built-in scenes: the eight, in the order they are verified", "[scenes]") {
    std::vector<std::string> names;
    for (const auto& entry : scenes::built_in_scenes()) {
        names.push_back(entry.name);
        CHECK_FALSE(entry.description.empty());
    }
    CHECK(names == std::vector<std::string>{"cornell", "spheres", "coil", "blob", "furnace", "veil",
                                            "slivers", "metals"});
}

TEST_CASE("built-in scenes: every one is valid, named, unit in its normals and the same twice",
          "[scenes]") {
    for (const auto& entry : scenes::built_in_scenes()) {
        INFO(entry.name);
        const Scene scene = load_scene(entry.name);
        CHECK(scene.name == entry.name);
        CHECK(scene.source == entry.name);
        CHECK(tests::worst_normal(scene) < 1e-5f);
        CHECK((scene.normals.empty() || scene.normals.size() == scene.vertices.size()));
        CHECK(reference::fingerprint(scene) == reference::fingerprint(load_scene(entry.name)));
        // The listed parameters are a specification, and the one that is the default.
        if (!entry.parameters.empty()) {
            const Scene same = load_scene(entry.name + ":" + entry.parameters);
            CHECK(reference::fingerprint(same) == reference::fingerprint(scene));
        }
    }
}

TEST_CASE("built-in scenes: no two have the same fingerprint", "[scenes]") {
    std::set<std::uint64_t> prints;
    for (const auto& entry : scenes::built_in_scenes()) {
        prints.insert(reference::fingerprint(load_scene(entry.name)));
    }
    CHECK(prints.size() == scenes::built_in_scenes().size());
}

TEST_CASE("cornell: five walls and a lamp that faces down, counted once", "[scenes]") {
    const Scene scene = load_scene("cornell");
    CHECK(scene.triangles.size() == 12);
    CHECK(scene.normals.empty());
    CHECK(scene.warnings.empty());
    REQUIRE(scene.lights.size() == 1);
    const Light& light = scene.lights.front();
    CHECK(light.kind == LightKind::parallelogram);
    CHECK(light.normal == Vec3(0, -1, 0));
    CHECK(light.position.y < 2.0f);
    CHECK(light.position.y > 1.9f);
    CHECK(light.area == Approx(0.5625));
    std::size_t emitters = 0;
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        const auto& material = scene.materials[scene.material_of[i]];
        if (reference::is_zero(material.emission)) continue;
        ++emitters;
        CHECK(material.emission_is_sampled == 1);
        CHECK(material.emission == light.radiance);
        CHECK(tests::front_of(scene, i) == light.normal);
        for (const std::uint32_t v : scene.triangles[i]) {
            CHECK(scene.vertices[v].y == light.position.y);
        }
    }
    CHECK(emitters == 2);
}

TEST_CASE("cornell: red on the left, green on the right, every wall faces the room", "[scenes]") {
    const Scene scene = load_scene("cornell");
    const Vec3 middle(0, 1, 0);
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        const Vec3& on_wall = scene.vertices[scene.triangles[i][0]];
        CHECK(reference::dot(tests::front_of(scene, i), middle - on_wall) > 0.0f);
        const Vec3& colour = scene.materials[scene.material_of[i]].reflectance;
        const Vec3 front = tests::front_of(scene, i);
        if (front == Vec3(1, 0, 0)) CHECK(colour.x > 2 * colour.y);
        if (front == Vec3(-1, 0, 0)) CHECK(colour.y > 2 * colour.x);
    }
}

TEST_CASE("spheres: one mirror and one glass sphere, both closed with fronts outside", "[scenes]") {
    const Scene scene = load_scene("spheres");
    for (const MaterialKind kind : {MaterialKind::mirror, MaterialKind::glass}) {
        const std::uint32_t material = material_of_kind(scene, kind);
        CHECK(tests::count_of_material(scene, material) == 20u * 16 * 16);
        CHECK(tests::open_edges(scene, material) == 0);
        CHECK(tests::signed_volume(scene, material) > 0.0);
    }
    CHECK(scene.materials[material_of_kind(scene, MaterialKind::glass)].ior == 1.5f);
    CHECK(load_scene("spheres:frequency=2").triangles.size() == 12 + 2 * 80);
}

TEST_CASE("coil: has about 8,000 triangles and is closed", "[scenes]") {
    const Scene scene = load_scene("coil");
    const std::uint32_t metal = material_of_kind(scene, MaterialKind::mirror);
    CHECK(tests::count_of_material(scene, metal) == 7896);
    CHECK(tests::open_edges(scene, metal) == 0);
    CHECK(tests::signed_volume(scene, metal) > 0.0);
    const reference::Bounds box = reference::bounds_of(scene);
    CHECK(box.low.y == 0.0f);
    CHECK(box.high.y == 2.0f);
}

TEST_CASE("coil: turns, segments and sides are parameters", "[scenes]") {
    const Scene scene = load_scene("coil:turns=2.5,segments=10,sides=4");
    CHECK(scene.triangles.size() == 12 + 2 * 10 * 4 + 2 * 4);
    CHECK(tests::open_edges(scene, material_of_kind(scene, MaterialKind::mirror)) == 0);
}

TEST_CASE("blob: 20,480 triangles, closed, fronts outside, inside the room", "[scenes]") {
    const Scene scene = load_scene("blob");
    CHECK(scene.warnings.empty());
    const auto blob = static_cast<std::uint32_t>(scene.materials.size() - 1);
    CHECK(tests::count_of_material(scene, blob) == 20480);
    CHECK(scene.vertices.size() == 24 + 10242);
    CHECK(tests::open_edges(scene, blob) == 0);
    CHECK(tests::signed_volume(scene, blob) > 0.0);
    const reference::Bounds box = reference::bounds_of(scene);
    CHECK(box.low == Vec3(-1, 0, -1));
    CHECK(box.high == Vec3(1, 2, 1));
}

TEST_CASE("blob: is not a sphere", "[scenes]") {
    const Scene scene = load_scene("blob");
    float low = 1e9f;
    float high = 0.0f;
    for (std::size_t i = 24; i < scene.vertices.size(); ++i) {
        const float r = reference::length(scene.vertices[i] - Vec3(0, 0.85f, 0));
        low = std::min(low, r);
        high = std::max(high, r);
    }
    CHECK(high / low > 1.2f);
}

TEST_CASE("blob: rounds up to the next size and says so, only where it differs", "[scenes]") {
    const Scene rounded = load_scene("blob:triangles=20000");
    CHECK(rounded.triangles.size() == 12 + 20480);
    CHECK(tests::warns(rounded, "20000 triangles asked for, 20480 made"));
    CHECK(load_scene("blob:triangles=20").triangles.size() == 12 + 20);
    CHECK(load_scene("blob:triangles=80").warnings.empty());
    CHECK(load_scene("blob:triangles=81").triangles.size() == 12 + 180);
}

TEST_CASE("blob: a million triangles in proportionate memory", "[scenes]") {
    const Scene scene = load_scene("blob:triangles=1e6");
    CHECK(scene.triangles.size() == 12 + 1003520);
    CHECK(scene.vertices.size() == 24 + 10u * 224 * 224 + 2);
    CHECK(scene.vertices.capacity() <= scene.vertices.size() + 64);
    CHECK(scene.triangles.capacity() <= scene.triangles.size() + 64);
}

TEST_CASE("furnace: closed, faces inwards, glows without a light", "[scenes]") {
    const Scene scene = load_scene("furnace");
    CHECK(scene.lights.empty());
    CHECK(scene.warnings.empty());
    CHECK(scene.triangles.size() == 12);
    CHECK(tests::open_edges(scene, 0) == 0);
    CHECK(tests::signed_volume(scene, 0) < 0.0);
    CHECK(scene.materials[0].emission_is_sampled == 0);
    CHECK(scene.materials[0].emission == Vec3(0.5f, 0.5f, 0.5f));
    CHECK(load_scene("furnace:albedo=0.8").materials[0].reflectance == Vec3(0.8f, 0.8f, 0.8f));
    const reference::Bounds box = reference::bounds_of(scene);
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(scene.camera.position[axis] > box.low[axis]);
        CHECK(scene.camera.position[axis] < box.high[axis]);
    }
}

TEST_CASE("veil: a ray through the middle meets all 64 sheets and the wall", "[scenes]") {
    const Scene scene = load_scene("veil");
    for (const Vec3& target : {Vec3(0, 1, 0), Vec3(0.1f, 1.2f, 0), Vec3(-0.2f, 0.9f, 0)}) {
        std::size_t met = 0;
        for (std::size_t i = 4; i < scene.triangles.size(); ++i) {
            met += meets(scene, i, scene.camera.position, target - scene.camera.position) ? 1u : 0u;
        }
        CHECK(met >= 64);
        CHECK(met <= 66);  // a ray on the diagonal of a sheet meets both its triangles
    }
    CHECK(lights_of_kind(scene, LightKind::point) == 1);
    CHECK(lights_of_kind(scene, LightKind::directional) == 1);
    CHECK(load_scene("veil:layers=5").triangles.size() == 4 + 10);
}

TEST_CASE("slivers: has needles, ties, empty triangles, and lights of every open kind",
          "[scenes]") {
    const Scene scene = load_scene("slivers");
    CHECK(tests::warns(scene, "4 triangles have zero area"));
    CHECK(lights_of_kind(scene, LightKind::environment) == 1);
    CHECK(lights_of_kind(scene, LightKind::directional) == 1);
    CHECK(lights_of_kind(scene, LightKind::point) == 1);
    std::size_t needles = 0;
    std::map<std::array<float, 9>, int> same;
    for (const auto& [a, b, c] : scene.triangles) {
        const Vec3& p = scene.vertices[a];
        const Vec3& q = scene.vertices[b];
        const Vec3& r = scene.vertices[c];
        const float longest = std::max(
            {reference::length(q - p), reference::length(r - q), reference::length(p - r)});
        const float doubled_area = reference::length(reference::cross(q - p, r - p));
        if (doubled_area > 0 && longest * longest / doubled_area > 1e5f) ++needles;
        ++same[{p.x, p.y, p.z, q.x, q.y, q.z, r.x, r.y, r.z}];
    }
    CHECK(needles > 100);
    std::size_t repeated = 0;
    for (const auto& [corners, count] : same) repeated += count > 1 ? 1u : 0u;
    CHECK(repeated == 2);
}
