
#include "scenes/file_scene.h"
#include "scenes/geodesic.h"
#include "scenes/mesh.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"

using namespace scotty;
using reference::LightKind;
using reference::Scene;
using reference::Vec3;

namespace {

std::uint32_t add_glow(Scene& scene, float radiance) {
    reference::Material material;
    material.emission = Vec3(radiance, radiance, radiance);
    return scenes::add_material(scene, material);
}

/// A unit square at height y that faces down, of a glowing material.
Scene glowing_square(float y, float radiance) {
    Scene scene;
    scenes::add_quad(scene, Vec3(0, y, 0), Vec3(1, 0, 0), Vec3(0, 0, 1), add_glow(scene, radiance));
    return scene;
}

reference::Light lamp_down(float y) {
    return scenes::parallelogram_light(Vec3(0, y, 0), Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(4, 4, 4));
}

std::vector<std::string> settle(Scene& scene) {
    scenes::Notes notes;
    scenes::settle_emission(scene, notes);
    notes.write_to(scene.warnings);
    return scene.warnings;
}

}  // namespace

TEST_CASE("emission: a mesh in an area light is that light's visible side", "[scenes]") {
    Scene scene = glowing_square(2.0f, 4.0f);
    scene.lights = {lamp_down(2.0f)};
    CHECK(settle(scene).empty());
    CHECK(scene.lights.size() == 1);
    CHECK(scene.materials.size() == 1);
    CHECK(scene.materials[scene.material_of[0]].emission_is_sampled == 1);
    CHECK(scene.materials[scene.material_of[1]].emission_is_sampled == 1);
}

TEST_CASE("emission: a mesh that faces away from its light is turned over", "[scenes]") {
    Scene scene = glowing_square(2.0f, 4.0f);
    for (auto& triangle : scene.triangles) std::swap(triangle[1], triangle[2]);
    scene.lights = {lamp_down(2.0f)};
    settle(scene);
    CHECK(tests::warns(scene, "turned over (2 times)"));
    CHECK(tests::front_of(scene, 0) == Vec3(0, -1, 0));
    CHECK(tests::front_of(scene, 1) == Vec3(0, -1, 0));
}

TEST_CASE("emission: a light behind its mesh is moved to the front", "[scenes]") {
    Scene scene = glowing_square(1.99f, 4.0f);
    scene.lights = {lamp_down(2.0f)};
    settle(scene);
    CHECK(tests::warns(scene, "moved to its front"));
    CHECK(scene.lights[0].position.y == Approx(1.99));
    CHECK(scene.lights.size() == 1);
}

TEST_CASE("emission: unequal radiances are named", "[scenes]") {
    Scene scene = glowing_square(2.0f, 10.0f);
    scene.lights = {lamp_down(2.0f)};
    settle(scene);
    CHECK(tests::warns(scene, "an area light's radiance is not that of the emissive mesh"));
}

TEST_CASE("emission: a mesh elsewhere becomes lights of its own", "[scenes]") {
    Scene scene = glowing_square(1.0f, 4.0f);
    scene.lights = {lamp_down(2.0f)};
    CHECK(settle(scene).empty());
    REQUIRE(scene.lights.size() == 3);
    CHECK(scene.lights[1].kind == LightKind::triangle);
    CHECK(scene.lights[1].normal == Vec3(0, -1, 0));
    CHECK(scene.lights[1].area == Approx(0.5));
    CHECK(scene.lights[2].radiance == Vec3(4, 4, 4));
    CHECK(scene.materials[scene.material_of[0]].emission_is_sampled == 1);
}

TEST_CASE("emission: too many emissive triangles stay for the paths to find", "[scenes]") {
    Scene scene;
    const std::uint32_t glow = add_glow(scene, 1.0f);
    scenes::add_sphere(scene, Vec3(0, 0, 0), 1.0f, 8, glow);
    REQUIRE(scene.triangles.size() > scenes::kMaxTriangleLights);
    settle(scene);
    CHECK(scene.lights.empty());
    CHECK(scene.materials[0].emission_is_sampled == 0);
    CHECK(tests::warns(scene, "1280 emissive triangles are too many"));
}

TEST_CASE("emission: one material, partly in a light and partly too much, is told apart",
          "[scenes]") {
    Scene scene = glowing_square(2.0f, 4.0f);
    scenes::add_sphere(scene, Vec3(5, 0, 0), 1.0f, 8, 0);
    scene.lights = {lamp_down(2.0f)};
    settle(scene);
    CHECK(scene.materials.size() == 2);
    CHECK(scene.materials[scene.material_of[0]].emission_is_sampled == 1);
    CHECK(scene.materials[scene.material_of[5]].emission_is_sampled == 0);
}
