#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "scenes/scene_summary.h"
#include "tests/scenes/collada_text.h"

using namespace scotty;
using Catch::Matchers::Contains;
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
        CHECK_THAT(written, Contains(words));
    }
    const nlohmann::json json = to_json(summary);
    CHECK(json["file"]["instances"] == 2);
    CHECK(json["camera"]["horizontal_degrees"].get<double>() == Approx(90));
    CHECK(json["fingerprint"].get<std::string>().size() == 16);
}

TEST_CASE("summary: what is not supported is told from what was repaired", "[scenes][summary]") {
    ColladaText text;
    text.has_camera = false;
    text.geometry = tests::replaced(text.geometry, "</mesh>", "<lines count=\"0\"/></mesh>");
    const SceneSummary summary = scenes::summarize(load(text));
    REQUIRE(summary.unsupported.size() == 1);
    CHECK_THAT(summary.unsupported[0], Contains("<lines>"));
    REQUIRE(summary.repaired.size() == 1);
    CHECK_THAT(summary.repaired[0], Contains("no camera in the file"));
}
