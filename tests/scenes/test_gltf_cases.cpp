/// Files that other readers got wrong, each with its right value. They are not part of this
/// repository: they lie in cases/ beside the folder of scenes that SCOTTY_SCENES names, or in
/// ../shared/cases beside the repository.
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::LightKind;
using reference::Scene;
using reference::Vec3;
using tests::warns;

namespace {

std::filesystem::path gltf_cases() {
    if (const char* named = std::getenv("SCOTTY_SCENES")) {
        return std::filesystem::path(named) / "../../cases";
    }
    return std::filesystem::path(SCOTTY_SOURCE_DIR).parent_path() / "shared/cases";
}

#define NEED_GLTF_CASES()                                                                \
    if (!std::filesystem::is_directory(gltf_cases())) {                                  \
        WARN("not run: the cases are not in " << gltf_cases() << "; set SCOTTY_SCENES"); \
        return;                                                                          \
    }

Scene load_case(const std::string& name) {
    return scenes::load_scene((gltf_cases() / name).string());
}

/// Smallest and largest coordinates.
std::array<Vec3, 2> extent(const Scene& scene) {
    const reference::Bounds box = reference::bounds_of(scene);
    return {box.low, box.high};
}

}  // namespace

TEST_CASE("glTF cases: cameras, lights and scenes are those of the file", "[scenes][gltf][cases]") {
    NEED_GLTF_CASES();
    CHECK(load_case("gltf-camera-order/cam10.gltf").camera.tan_half_fov == Approx(std::tan(0.6)));
    CHECK(load_case("gltf-camera-order/cam1.gltf").camera.tan_half_fov == Approx(std::tan(0.6)));
    CHECK(load_case("gltf-camera-order/cam01.gltf").camera.tan_half_fov == Approx(std::tan(0.1)));
    CHECK(warns(load_case("gltf-emissive-double-sided/emit_ds1.gltf"), "front side only"));
    CHECK_FALSE(warns(load_case("gltf-emissive-double-sided/emit_ds0.gltf"), "front side only"));
    CHECK(warns(load_case("gltf-light-range/l_range.gltf"), "range"));
    for (const char* name :
         {"gltf-light-shared-by-nodes/l_shared.gltf", "gltf-lights-same-name/l_dup.gltf"}) {
        const Scene scene = load_case(name);
        REQUIRE(scene.lights.size() == 2);
        for (const auto& light : scene.lights) {
            CHECK(light.kind == LightKind::point);
            CHECK(light.position == Vec3(0, 0, 1));
            CHECK(light.radiance.x == Approx(3.14159265));
        }
    }
    const Scene named = load_case("gltf-lights-same-name/l_camname.gltf");
    CHECK(named.lights.size() == 1);
    CHECK_FALSE(warns(named, "further camera"));
    const Scene second = load_case("gltf-second-scene-or-unused-mesh/scene1.gltf");
    CHECK(second.materials.at(0).reflectance == Vec3(0, 1, 0));
    for (const char* name : {"noscene", "unused_mesh"}) {
        const Scene scene =
            load_case(std::string("gltf-second-scene-or-unused-mesh/") + name + ".gltf");
        CHECK(scene.triangles.size() == 2);
        CHECK(scene.materials.at(0).reflectance == Vec3(1, 0, 0));
    }
}

TEST_CASE("glTF cases: quantised, skinned and oddly named data", "[scenes][gltf][cases]") {
    NEED_GLTF_CASES();
    for (const char* name :
         {"gltf-required-extension/quant14.gltf", "gltf-required-extension/quant_norm.gltf",
          "gltf-required-extension/quant_normal.gltf", "gltf-required-extension/quant_short.gltf",
          "gltf-skin-no-inverse-bind/skin.gltf"}) {
        INFO(name);
        const Scene scene = load_case(name);
        CHECK(scene.triangles.size() == 2);
        const auto [low, high] = extent(scene);
        CHECK(reference::length(low - Vec3(-1, -1, 0)) < 1e-4f);
        CHECK(reference::length(high - Vec3(1, 1, 0)) < 1e-4f);
        for (const Vec3& normal : scene.normals) CHECK(normal == Vec3(0, 0, 1));
    }
    CHECK(load_case("gltf-uri-percent/uri_my data.gltf").triangles.size() == 2);
}

TEST_CASE("glTF cases: what cannot be read is refused by name", "[scenes][gltf][cases]") {
    NEED_GLTF_CASES();
    CHECK_THROWS_WITH(load_case("gltf-1.0-message/v1.gltf"),
                      ContainsSubstring("glTF 1.0 is not supported"));
    CHECK_THROWS_WITH(load_case("gltf-required-extension/req_unknown.gltf"),
                      ContainsSubstring("EXT_not_known"));
    CHECK_THROWS_WITH(load_case("gltf-required-extension/gpuinst.gltf"),
                      ContainsSubstring("EXT_mesh_gpu_instancing"));
    CHECK_THROWS_WITH(load_case("gltf-strip-bad-index/strip_bad.gltf"),
                      ContainsSubstring("meshes[0]") && ContainsSubstring("99"));
    CHECK_THROWS_WITH(load_case("gltf-strip-bad-index/strip_hides.gltf"),
                      ContainsSubstring("meshes[1]") && ContainsSubstring("77"));
}
