#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scenes/scene_summary.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/gltf_text.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Vec3;
using scenes::SceneSummary;
using tests::ColladaText;

TEST_CASE("summary: a COLLADA file", "[scenes][summary]") {
    ColladaText text;
    text.more_nodes =
        "<node><translate>0 0 3</translate><instance_geometry url=\"#square\"/></node>"
        "<node><instance_camera url=\"#cam\"/></node>";
    text.common = tests::replaced(text.common, "</lambert>",
                                  "<emission><color>1 1 1 1</color></emission></lambert>");
    text.optics = "<perspective><xfov>90</xfov></perspective>";
    const SceneSummary summary = scenes::summarize(load(text));
    CHECK(summary.file.meshes == 1);
    CHECK(summary.file.instances == 2);
    CHECK(summary.file.cameras == 2);
    CHECK(summary.file.lights == 1);
    CHECK(summary.triangles == 4);
    CHECK(summary.vertices == 8);
    CHECK(summary.smooth_vertices == 8);
    CHECK(summary.materials == decltype(summary.materials){2});
    CHECK(summary.emissive_materials == 1);
    CHECK(summary.lights[1] == 2);
    CHECK(summary.lights[4] == 1);
    CHECK(summary.extents.low == Vec3(0, 0, 0));
    CHECK(summary.extents.high == Vec3(1, 1, 3));
    CHECK(summary.unsupported.empty());
    CHECK(summary.repaired.size() == 2);
    const std::string written = to_text(summary);
    for (const char* words : {"1, placed 2 times", "2 diffuse; 1 of them shine",
                              "2 triangle, 1 environment", "90 degrees wide; 2 in the file",
                              "(0, 0, 0) to (1, 1, 3), 1 x 1 x 3 m", "a further camera"}) {
        CHECK_THAT(written, ContainsSubstring(words));
    }
    const nlohmann::json json = to_json(summary);
    CHECK(json["file"]["instances"] == 2);
    CHECK(json["camera"]["horizontal_degrees"].get<double>() == Approx(90));
    CHECK(json["fingerprint"].get<std::string>().size() == 16);
}

TEST_CASE("summary: every kind of light has a name", "[scenes][summary]") {
    const std::array<const char*, reference::kLightKinds> names = {
        "parallelogram", "triangle", "point", "directional", "environment", "hemisphere", "spot"};
    for (std::size_t kind = 0; kind < names.size(); ++kind) {
        reference::Scene scene = scenes::load_scene("cornell");
        scene.lights.assign(kind + 1, scene.lights[0]);
        for (auto& light : scene.lights) light.kind = static_cast<reference::LightKind>(kind);
        const SceneSummary summary = scenes::summarize(scene);
        CHECK(summary.lights[kind] == kind + 1);
        CHECK_THAT(to_text(summary),
                   ContainsSubstring(fmt::format("{} {}", kind + 1, names[kind])));
        CHECK(to_json(summary)["lights"][names[kind]] == kind + 1);
    }
}

TEST_CASE("summary: files of all formats say what they hold", "[scenes][summary]") {
    const tests::TemporaryFiles files;
    const auto contents = [](const reference::Scene& scene) {
        const auto& [meshes, instances, cameras, lights] = scene.file;
        return std::array<std::size_t, 4>{meshes, instances, cameras, lights};
    };
    using Counts = std::array<std::size_t, 4>;
    const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    CHECK(contents(files.load("a.obj", square + "f 1 2 3 4\n")) == Counts{1, 1, 0, 0});
    CHECK(contents(files.load("a.ply",
                              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                              "property float y\nproperty float z\nelement face 1\n"
                              "property list uchar int vertex_indices\nend_header\n"
                              "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")) == Counts{1, 1, 0, 0});
    tests::GltfText text = tests::square_gltf();
    text.node({{"mesh", 0}, {"translation", {0, 0, 1}}});
    text.append("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}}}});
    for (int i = 0; i < 3; ++i) text.node({{"camera", 0}, {"translation", {0, 0, 5 + i}}});
    text.node(text.light_node(text.light({{"type", "point"}})));
    const reference::Scene scene = tests::load_gltf(text);
    CHECK(contents(scene) == Counts{1, 2, 3, 1});
    CHECK_THAT(to_text(scenes::summarize(scene)),
               ContainsSubstring("1, placed 2 times") && ContainsSubstring("3 in the file"));
}

TEST_CASE("summary: what is not supported is told from what was repaired", "[scenes][summary]") {
    ColladaText text;
    text.has_camera = false;
    text.geometry = tests::replaced(text.geometry, "</mesh>", "<lines count=\"0\"/></mesh>");
    const SceneSummary summary = scenes::summarize(load(text));
    REQUIRE(summary.unsupported.size() == 1);
    CHECK_THAT(summary.unsupported[0], ContainsSubstring("<lines>"));
    REQUIRE(summary.repaired.size() == 1);
    CHECK_THAT(summary.repaired[0], ContainsSubstring("no camera in the file"));
}
