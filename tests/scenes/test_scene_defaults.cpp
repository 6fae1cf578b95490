/// What is added to a file that has no camera or no light.
#include <cmath>
#include <set>

#include "scenes/file_scene.h"
#include "scenes/geodesic.h"
#include "scenes/mesh.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Camera;
using reference::LightKind;
using reference::Scene;
using reference::Vec3;
using tests::TemporaryFiles;
using tests::warns;

namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

Scene sphere_of(float radius, const Vec3& centre = Vec3(0.0f)) {
    Scene scene;
    const std::uint32_t white = scenes::add_diffuse(scene, Vec3(1.0f));
    scenes::add_sphere(scene, centre, radius, 8, white);
    return scene;
}

/// The largest distance of a vertex from the middle of a square picture, in half widths of it.
float reach(const Scene& scene) {
    const Camera& camera = scene.camera;
    float most = 0.0f;
    for (const Vec3& vertex : scene.vertices) {
        const Vec3 offset = vertex - camera.position;
        const float depth = reference::dot(offset, camera.forward);
        CHECK(depth > 0.0f);
        for (const Vec3& axis : {camera.right, camera.up}) {
            most = std::max(most,
                            std::abs(reference::dot(offset, axis)) / (depth * camera.tan_half_fov));
        }
    }
    return most;
}

/// Radiance of a white diffuse surface that sees all of the sky on its side.
float brightness(const Scene& scene, const Vec3& normal) {
    float sum = 0.0f;
    for (const auto& light : scene.lights) {
        if (light.kind == LightKind::environment) sum += light.radiance.x;
        if (light.kind == LightKind::directional) {
            sum += light.radiance.x / 3.14159265f *
                   std::max(0.0f, -reference::dot(light.normal, normal));
        }
    }
    return sum;
}

}  // namespace

TEST_CASE("defaults: a fitted camera frames the scene at any scale", "[scenes][defaults]") {
    const float reference_reach = [] {
        Scene scene = sphere_of(1.0f);
        scenes::Notes notes;
        scenes::settle_camera(scene, {}, scenes::CameraChoice::automatic, notes);
        return reach(scene);
    }();
    CHECK(reference_reach > 0.5f);
    for (int exponent = -10; exponent <= 10; ++exponent) {
        INFO("radius 1e" << exponent);
        const float radius = static_cast<float>(std::pow(10.0, exponent));
        Scene scene = sphere_of(radius, Vec3(0.0f, 3.0f * radius, 0.0f));
        scenes::Notes notes;
        scenes::settle_camera(scene, {}, scenes::CameraChoice::automatic, notes);
        CHECK(reach(scene) == Approx(reference_reach).epsilon(1e-3));
    }
}

TEST_CASE("defaults: no camera is placed where the file's own was asked for",
          "[scenes][defaults]") {
    reference::Scene scene = scenes::load_scene("cornell");
    scenes::Notes notes;
    CHECK_THROWS_WITH(
        scenes::settle_camera(scene, {}, scenes::CameraChoice::file, notes),
        ContainsSubstring("cornell: has no camera") && ContainsSubstring("#camera=file"));
}

TEST_CASE("defaults: a scene that is one point still has a camera in front of it",
          "[scenes][defaults]") {
    const Scene scene = TemporaryFiles().load("a.obj", "v 2 2 2\nv 2 2 2\nv 2 2 2\nf 1 2 3\n");
    CHECK(reach(scene) < 1e-3f);
}

TEST_CASE("defaults: the added lights tell the sides of a white cube apart, wherever the camera is",
          "[scenes][defaults]") {
    for (const Vec3& eye : {Vec3(3, 2, 4), Vec3(-3, 1, -4), Vec3(1, -5, 2), Vec3(-4, 3, 0.5f)}) {
        INFO("seen from " << eye.x << " " << eye.y << " " << eye.z);
        Scene scene = sphere_of(1.0f);
        scene.camera = scenes::look_at(eye, Vec3(0.0f), Vec3(0, 1, 0), 0.4f);
        scenes::Notes notes;
        scenes::add_default_lights(scene, notes);
        std::set<float> seen;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 normal(0.0f);
            normal[axis] = eye[axis] > 0.0f ? 1.0f : -1.0f;
            seen.insert(brightness(scene, normal));
        }
        REQUIRE(seen.size() == 3);
        CHECK(*seen.rbegin() <= 1.0f);
        CHECK(*seen.rbegin() - *seen.begin() > 0.2f);
        // What faces the camera stands out from the sky behind it.
        CHECK(brightness(scene, -scene.camera.forward) > brightness(scene, Vec3(0.0f)) + 0.4f);
    }
}

TEST_CASE("defaults: lights are added only where nothing shines, and can be turned off",
          "[scenes][defaults]") {
    const TemporaryFiles files;
    const std::string path = files.write("a.obj", kTriangle);
    const Scene lit = scenes::load_scene(path);
    CHECK(lit.lights.size() == 2);
    CHECK(warns(lit, "no light in the file"));
    CHECK(warns(lit, "#lights=none"));
    for (const char* choice :
         {"#lights=none", "#camera=fit,lights=none", "#lights=none#camera=fit"}) {
        const Scene dark = scenes::load_scene(path + choice);
        CHECK(dark.lights.empty());
        CHECK_FALSE(warns(dark, "no light in the file"));
        CHECK(warns(dark, "the picture is black"));
    }
    const std::string glowing = "mtllib a.mtl\nusemtl glow\n" + kTriangle;
    files.write("a.mtl", "newmtl glow\nKe 1 1 1\n");
    CHECK_FALSE(warns(scenes::load_scene(files.write("a.obj", glowing)), "no light in the file"));
}
