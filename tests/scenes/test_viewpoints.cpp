/// Files with several cameras: their names, and looking from one of them.

#include "scenes/viewpoints.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::Scene;
using reference::Vec3;
using scenes::Viewpoint;
using tests::ColladaText;
using tests::GltfText;
using tests::TemporaryFiles;
using tests::warns;

namespace {

std::vector<std::string> names(const std::vector<Viewpoint>& viewpoints) {
    std::vector<std::string> out;
    for (const Viewpoint& viewpoint : viewpoints) out.push_back(viewpoint.name);
    return out;
}

/// Cameras at z = 1, 2, ... under these names; the file has no light.
GltfText cameras_at(const std::vector<std::string>& camera_names) {
    GltfText text = tests::square_gltf();
    text.append("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    for (std::size_t i = 0; i < camera_names.size(); ++i) {
        json node = {{"camera", 0}, {"translation", {0, 0, i + 1}}};
        if (!camera_names[i].empty()) node["name"] = camera_names[i];
        text.node(node);
    }
    return text;
}

}  // namespace

TEST_CASE("viewpoints: each camera of a glTF file has a name that a specification takes",
          "[scenes][viewpoints]") {
    const TemporaryFiles files;
    const std::string file = files.write(
        "a.gltf", cameras_at({"Front", "a,b#c", "Front", "", "fit", "x.camera"}).gltf());
    std::vector<Viewpoint> viewpoints;
    const Scene own = load_scene(file, viewpoints);
    CHECK(names(viewpoints) ==
          std::vector<std::string>{"Front", "a_b_c", "Front 2", "camera 4", "fit 2", "x.camera 2"});
    CHECK(own.camera.position == Vec3(0, 0, 1));
    CHECK(warns(own, "#camera=NAME takes another: Front, a_b_c"));
    for (std::size_t i = 0; i < viewpoints.size(); ++i) {
        INFO(viewpoints[i].name);
        CHECK(viewpoints[i].camera.position == Vec3(0, 0, static_cast<float>(i + 1)));
        const Scene seen = scenes::load_scene(file + "#camera=" + viewpoints[i].name);
        CHECK(seen.camera.position == viewpoints[i].camera.position);
        // What lights the file, which has no light, does not go with the camera.
        REQUIRE(seen.lights.size() == own.lights.size());
        CHECK(seen.lights[0].normal == own.lights[0].normal);
    }
    CHECK(scenes::load_scene(file + "#camera=Front 2,lights=none").camera.position ==
          Vec3(0, 0, 3));
}

TEST_CASE("viewpoints: a COLLADA file's further cameras may be broken, its first may not",
          "[scenes][viewpoints]") {
    ColladaText text;
    text.more_nodes =
        "<node name=\"Side\"><translate>7 0 0</translate><instance_camera url=\"#cam\"/></node>"
        "<node name=\"Lost\"><instance_camera url=\"#nowhere\"/></node>";
    const TemporaryFiles files;
    const std::string file = files.write("a.dae", text.text());
    std::vector<Viewpoint> viewpoints;
    const Scene own = load_scene(file, viewpoints);
    CHECK(names(viewpoints) == std::vector<std::string>{"camera 1", "Side"});
    CHECK(own.camera.position == Vec3(0, 0, 5));
    CHECK(warns(own, "a further camera: left out"));
    CHECK(scenes::load_scene(file + "#camera=Side").camera.position == Vec3(7, 0, 0));
    text.has_camera = false;
    text.more_nodes = "<node name=\"Lost\"><instance_camera url=\"#nowhere\"/></node>";
    CHECK_THROWS_WITH(tests::load(text), ContainsSubstring("nowhere"));
}

TEST_CASE("viewpoints: a name that no camera has is an error with those that there are",
          "[scenes][viewpoints]") {
    const TemporaryFiles files;
    const std::string two = files.write("two.gltf", cameras_at({"Front", "Side"}).gltf());
    CHECK_THROWS_WITH(
        scenes::load_scene(two + "#camera=side"),
        ContainsSubstring("no camera 'side'") && ContainsSubstring("it has Front, Side"));
    const std::string none = files.write("none.gltf", cameras_at({}).gltf());
    CHECK_THROWS_WITH(scenes::load_scene(none + "#camera=Side"), ContainsSubstring("it has none"));
    std::vector<Viewpoint> viewpoints{{"before", {}}};
    load_scene("cornell", viewpoints);
    CHECK(viewpoints.empty());
    // A hostile file costs neither time nor memory.
    const std::string many =
        files.write("many.gltf", cameras_at(std::vector<std::string>(2000, "x")).gltf());
    load_scene(many, viewpoints);
    CHECK(viewpoints.size() == 256);
    CHECK(viewpoints.back().name == "x 256");
}
