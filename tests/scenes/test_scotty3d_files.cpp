/// The original Scotty3D scenes. They are not part of this repository: SCOTTY_SCENES names their
/// folder, or they lie in ../shared/scenes/scotty3d beside it. SCOTTY_SCENES set to nothing: do
/// without.
#include <cstdlib>
#include <filesystem>

#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"

using namespace scotty;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using scenes::load_scene;
using tests::warns;

namespace {

std::filesystem::path folder() {
    if (const char* named = std::getenv("SCOTTY_SCENES")) return named;
    return std::filesystem::path(SCOTTY_SOURCE_DIR).parent_path() / "shared/scenes/scotty3d";
}

/// Ends a test with "not run" (CTest: skipped) where the scenes are absent. A folder that was named
/// and is not there is a failure.
#define NEED_SCOTTY3D_SCENES()                                                                 \
    if (!std::filesystem::is_directory(folder())) {                                            \
        if (!folder().empty() && std::getenv("SCOTTY_SCENES") != nullptr)                      \
            FAIL("no such folder: " << folder());                                              \
        WARN("not run: the Scotty3D scenes are not in " << folder() << "; set SCOTTY_SCENES"); \
        return;                                                                                \
    }

Scene load(const std::string& name) { return load_scene((folder() / name).string()); }

std::size_t count_of_kind(const Scene& scene, MaterialKind kind) {
    std::size_t count = 0;
    for (const std::uint32_t m : scene.material_of) {
        count += scene.materials[m].kind == kind ? 1u : 0u;
    }
    return count;
}

}  // namespace

TEST_CASE("Scotty3D files: all of them load, with the right number of triangles",
          "[scenes][scotty3d]") {
    NEED_SCOTTY3D_SCENES();
    constexpr std::size_t kSphere = 11520;
    const std::map<std::string, std::size_t> expected = {
        {"CBbunny.dae", 28588},
        {"CBcoil.dae", 7884},
        {"CBempty.dae", 12},
        {"CBgems.dae", 252},
        {"CBspheres.dae", 12 + 2 * kSphere},
        {"CBspheres_lambertian.dae", 12 + 2 * kSphere},
        {"carim_glass.dae", 8 + 4 * kSphere},
        {"plane1024.dae", 2056},
        {"sphere7_diffuse.dae", 7 * kSphere},
        {"sphere7_glass.dae", 7 * kSphere},
        {"sphere7_mirror.dae", 7 * kSphere}};
    for (const auto& [name, triangles] : expected) {
        INFO(name);
        const Scene scene = load(name);
        CHECK(scene.triangles.size() == triangles);
        CHECK(tests::worst_normal(scene) < 1e-5f);
        CHECK_FALSE(warns(scene, "no camera"));
        CHECK_FALSE(warns(scene, "winding and normals disagree"));
        CHECK(reference::fingerprint(scene) == reference::fingerprint(load(name)));
    }
}

TEST_CASE("Scotty3D files: lamps of the boxes shine down, and count once", "[scenes][scotty3d]") {
    NEED_SCOTTY3D_SCENES();
    for (const char* name : {"CBbunny.dae", "CBcoil.dae", "CBgems.dae", "CBspheres.dae"}) {
        INFO(name);
        const Scene scene = load(name);
        REQUIRE(scene.lights.size() == 1);
        const auto& light = scene.lights[0];
        CHECK(light.kind == LightKind::parallelogram);
        CHECK(light.normal.y < -0.999f);
        CHECK(light.area == Approx(0.48));
        CHECK(light.position.y == Approx(1.49));
        for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
            const auto& material = scene.materials[scene.material_of[i]];
            if (reference::is_zero(material.emission)) continue;
            CHECK(material.emission == Vec3(10, 10, 10));
            CHECK(material.emission_is_sampled == 1);
            CHECK(tests::front_of(scene, i).y < -0.999f);
        }
    }
}

TEST_CASE("Scotty3D files: each material is what its extra says", "[scenes][scotty3d]") {
    NEED_SCOTTY3D_SCENES();
    const Scene spheres = load("CBspheres.dae");
    CHECK(count_of_kind(spheres, MaterialKind::mirror) == 11520);
    CHECK(count_of_kind(spheres, MaterialKind::glass) == 11520);
    const Scene coil = load("CBcoil.dae");
    CHECK(count_of_kind(coil, MaterialKind::mirror) == 7872);
    for (const auto& material : coil.materials) {
        if (material.kind == MaterialKind::mirror) {
            CHECK(material.reflectance == Vec3(0.3f, 0.3f, 0.3f));
        }
    }
    CHECK(count_of_kind(load("CBgems.dae"), MaterialKind::glass) == 240);
    CHECK(count_of_kind(load("CBbunny.dae"), MaterialKind::diffuse) == 28588);
}

TEST_CASE("Scotty3D files: the point and triangle lights of CBempty", "[scenes][scotty3d]") {
    NEED_SCOTTY3D_SCENES();
    const Scene scene = load("CBempty.dae");
    REQUIRE(scene.lights.size() == 3);
    CHECK(scene.lights[0].kind == LightKind::point);
    CHECK(scene.lights[1].kind == LightKind::triangle);
    CHECK(scene.lights[1].normal.y < -0.999f);
    CHECK(warns(scene, "attenuation"));
}

TEST_CASE("Scotty3D files: the camera frames the scene, the file's own position on demand",
          "[scenes][scotty3d]") {
    NEED_SCOTTY3D_SCENES();
    const Scene own = load("CBspheres.dae#camera=file");
    CHECK(reference::length(own.camera.position - Vec3(0, 0, -3)) < 1e-5f);
    CHECK(own.camera.forward.z > 0.999f);
    CHECK(own.camera.up.y > 0.999f);
    CHECK(load("CBbunny.dae").camera.tan_half_fov == Approx(0.257143));
    const Scene fitted = load("CBspheres.dae#camera=fit");
    CHECK(fitted.camera.forward == own.camera.forward);
    CHECK(fitted.camera.position.y == Approx(0.75));
    const Scene standard = load("CBspheres.dae");
    CHECK(standard.camera.position == fitted.camera.position);
    CHECK(warns(standard, "as Scotty3D does"));
    CHECK(warns(load("CBgems.dae"), "15 numbers instead of 16"));
}
