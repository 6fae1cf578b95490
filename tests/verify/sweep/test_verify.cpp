/// The verification as a whole: it passes on what is right, and on what is not it leads to the
/// first launch, level, node, block and ray, with a command that shows it again.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "verify/report/report.h"
#include "verify/sweep/verify.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using Catch::Matchers::ContainsSubstring;
using verify::Report;
using verify::SceneReport;
using verify::VerifySettings;

VerifySettings quick() {
    VerifySettings settings;
    settings.parameters = scotty::test::small_picture(13, 7);
    settings.filter.widths = {4};
    settings.filter.early_out = {EarlyOut::level};
    settings.filter.queues = {scotty::reference::QueueKind::nodes};
    settings.filter.schedule = {verify::Schedule{}};
    return settings;
}

/// Loses the last ray of a queue in the stage of that name, in one configuration.
VerifySettings::Tamper lose_a_ray(const std::string& name, std::size_t in_configuration) {
    return [=](const StageView& stage, std::size_t configuration, const auto& show) {
        if (stage.name != name || configuration != in_configuration) return show(stage);
        StageView spoiled = stage;
        const auto counts = stage.get<std::uint32_t>("child_counts");
        std::vector<std::uint32_t> fewer(counts.begin(), counts.end());
        for (std::uint32_t& count : fewer) {
            if (count == 0) continue;
            --count;
            break;
        }
        for (BufferView& buffer : spoiled.outputs) {
            if (buffer.name == "child_counts") buffer.data = fewer.data();
        }
        show(spoiled);
    };
}

Report report_of(SceneReport scene) {
    Report report;
    report.scenes.push_back(std::move(scene));
    return report;
}

TEST_CASE("verify: a scene that no ray hits passes with a warning", "[verify][whole]") {
    const auto warns_of_nothing = [](const Scene& scene) {
        const SceneReport report = verify::verify_scene(scene, quick());
        CHECK(report.passed());
        for (const std::string& warning : report.warnings) {
            if (warning.find("no ray hit anything") != std::string::npos) return true;
        }
        return false;
    };
    Scene scene = scenes::load_scene("cornell");
    CHECK_FALSE(warns_of_nothing(scene));
    SECTION("the camera looks away") {
        scene.camera.position = Vec3(0.0f, 0.0f, 1e3f);
        scene.camera.forward = -scene.camera.forward;
        scene.camera.right = -scene.camera.right;
    }
    SECTION("triangles without area") {
        for (auto& triangle : scene.triangles) triangle[2] = triangle[1];
    }
    CHECK(warns_of_nothing(scene));
}

TEST_CASE("verify: a right pipeline passes, and everything was looked at", "[verify][whole]") {
    std::size_t steps = 0;
    VerifySettings settings = quick();
    settings.progress = [&](const std::string&, std::size_t done, std::size_t total) {
        CHECK(done == steps);
        ++steps;
        CHECK(steps <= total);
    };
    const SceneReport report = verify_scene(scenes::load_scene("spheres"), settings);
    CHECK(report.passed());
    CHECK(report.configurations.size() > 5);
    CHECK(steps == report.configurations.size() + 1);
    CHECK(report.hits.brute_force_rays > 100);
    CHECK(report.image.pixels == 13u * 7);
    for (const auto& configuration : report.configurations) {
        CHECK(configuration.counts.stages > 20);
        CHECK(configuration.rays == report.configurations.front().rays);
    }
}

TEST_CASE("verify: a lost pair leads to its launch, level, node, block and ray",
          "[verify][whole]") {
    VerifySettings settings = quick();
    settings.filter.queue_levels = {0};
    settings.filter.queues = {scotty::reference::QueueKind::pairs};
    settings.tamper = [](const StageView& stage, std::size_t configuration, const auto& show) {
        StageView spoiled = stage;
        for (BufferView& buffer : spoiled.outputs) {
            const bool here = configuration == 2 && stage.name == "bounce0/level1/intersect";
            if (!here || buffer.name != "child_pairs") continue;
            --buffer.shape[0];
            buffer.bytes -= 8;
        }
        show(spoiled);
    };
    const SceneReport scene = verify_scene(scenes::load_scene("spheres"), settings);
    CHECK_FALSE(scene.passed());
    CHECK(scene.configurations[0].failures.empty());
    CHECK(scene.configurations[1].failures.empty());
    const auto failures = placed_failures(report_of(scene));
    REQUIRE_FALSE(failures.empty());
    const verify::Failure& first = failures.front().failure;
    CHECK(first.invariant == "required-present");
    CHECK(first.stage == "bounce0/level1/intersect");
    CHECK(first.level == 1);
    CHECK(first.node != kNotApplicable);
    CHECK(first.block != kNotApplicable);
    CHECK(first.ray < 13u * 7);
}

TEST_CASE("verify: a lost ray leads to its launch, level, node, block and ray", "[verify][whole]") {
    VerifySettings settings = quick();
    settings.filter.queue_levels = {0};
    settings.tamper = lose_a_ray("bounce0/level1/intersect", 2);
    const SceneReport scene = verify_scene(scenes::load_scene("spheres"), settings);
    CHECK_FALSE(scene.passed());
    CHECK(scene.configurations[0].failures.empty());
    CHECK(scene.configurations[1].failures.empty());
    const Report report = report_of(scene);
    const auto failures = placed_failures(report);
    REQUIRE_FALSE(failures.empty());
    const verify::Failure& first = failures.front().failure;
    CHECK(first.invariant == "required-present");
    CHECK(first.stage == "bounce0/level1/intersect");
    CHECK(first.launch == 5);  // after primary rays, level 0's three, and the scan
    CHECK(first.level == 1);
    CHECK(first.node != kNotApplicable);
    CHECK(first.block != kNotApplicable);
    CHECK(first.ray < 13u * 7);
    CHECK_THAT(failures.front().replay,
               ContainsSubstring("scotty verify 'spheres' --size 13x7 --spp 1 --bounces 1") &&
                   ContainsSubstring("--width 4 ") && ContainsSubstring("--early-out level") &&
                   ContainsSubstring("--stage 'bounce0/level1/intersect'"));
    CHECK_THAT(table(report), ContainsSubstring("FAILED") && ContainsSubstring("first failure") &&
                                  ContainsSubstring("launch 5 bounce0/level1/intersect"));
    CHECK_FALSE(to_json(report)["passed"].get<bool>());
    CHECK(to_json(report)["failures"][0]["ray"] == first.ray);
}

TEST_CASE("verify: a failure of the baseline leads before all others", "[verify][whole]") {
    VerifySettings settings = quick();
    settings.tamper = lose_a_ray("bounce0/level0/intersect_root", 0);
    const SceneReport scene = verify_scene(scenes::load_scene("cornell"), settings);
    const auto failures = placed_failures(report_of(scene));
    REQUIRE_FALSE(failures.empty());
    CHECK_THAT(failures.front().configuration, ContainsSubstring("baseline"));
}

TEST_CASE("verify: radiance that depends on a configuration is found by the comparison",
          "[verify][whole]") {
    VerifySettings settings = quick();
    settings.oracles = false;
    settings.tamper = [](const StageView& stage, std::size_t configuration, const auto& show) {
        if (stage.kind != StageKind::reconstruct_image || configuration != 1) return show(stage);
        const auto radiance = stage.get<Vec3>("radiance");
        std::vector<Vec3> other(radiance.begin(), radiance.end());
        other[40].x += 0.5f;
        StageView spoiled = stage;
        spoiled.inputs[0].data = other.data();
        show(spoiled);
    };
    const SceneReport scene = verify_scene(scenes::load_scene("cornell"), settings);
    CHECK_FALSE(scene.oracles_ran);
    bool found = false;
    for (const verify::Failure& failure : scene.configurations[1].failures) {
        found = found || (failure.invariant == "same-as-baseline" && failure.ray == 40);
    }
    CHECK(found);
    CHECK(scene.configurations[2].failures.empty());
}

TEST_CASE("verify: a stage pattern judges those stages alone", "[verify][whole]") {
    VerifySettings settings = quick();
    settings.tamper = lose_a_ray("bounce0/level1/intersect", 1);
    settings.stage_pattern = "bounce1/*";
    CHECK(verify_scene(scenes::load_scene("spheres"), settings).passed());
    settings.stage_pattern = "bounce0/level1/intersect";
    const SceneReport scene = verify_scene(scenes::load_scene("spheres"), settings);
    CHECK_FALSE(scene.passed());
    CHECK(scene.configurations[1].counts.stages == 1);
}

TEST_CASE("report: JUnit counts cases and carries failures, HTML stands alone",
          "[verify][report]") {
    VerifySettings settings = quick();
    settings.oracles = false;
    settings.tamper = lose_a_ray("bounce0/level1/intersect", 1);
    const Report report = report_of(verify_scene(scenes::load_scene("spheres"), settings));
    pugi::xml_document junit;
    REQUIRE(junit.load_string(to_junit(report).c_str()));
    const pugi::xml_node suite = junit.child("testsuites").child("testsuite");
    CHECK(suite.attribute("failures").as_int() == 1);
    CHECK(suite.attribute("tests").as_uint() == report.scenes[0].configurations.size() + 1);
    CHECK(std::string(suite
                          .find_child_by_attribute("testcase", "name",
                                                   report.scenes[0].configurations[1].label.c_str())
                          .child("failure")
                          .attribute("type")
                          .value()) == "required-present");
    const std::string html = to_html(report);
    CHECK_THAT(html, ContainsSubstring("FAILED") && ContainsSubstring("bounce0/level1/intersect"));
    CHECK_THAT(html, !ContainsSubstring("http:") && !ContainsSubstring("https:") &&
                         !ContainsSubstring("src="));
}

TEST_CASE("report: a file that cannot be written is named, and none is left half-written",
          "[verify][report]") {
    const auto folder = std::filesystem::temp_directory_path() / "scotty_report_test";
    std::filesystem::remove_all(folder);
    const std::string path = (folder / "deep" / "verify.json").string();
    reference::write_file(path, "{}\n");
    CHECK(std::filesystem::file_size(path) == 3);
    CHECK_THROWS_WITH(reference::write_file(path + "/inside", "x"),
                      ContainsSubstring("verify.json/inside"));
    CHECK(std::distance(std::filesystem::directory_iterator(folder / "deep"), {}) == 1);
    std::filesystem::remove_all(folder);
}

TEST_CASE("verify: the first failure is told at once, once, and --fail-fast ends there",
          "[verify][sweep]") {
    const Scene scene = scenes::load_scene("cornell");
    VerifySettings settings = quick();
    settings.oracles = false;
    const std::size_t all = verify::all_configurations(settings).size();
    REQUIRE(all > 3);
    settings.tamper = lose_a_ray("bounce0/level0/intersect_root", 1);
    std::vector<verify::PlacedFailure> told;
    settings.on_first_failure = [&](const verify::PlacedFailure& first) { told.push_back(first); };
    const SceneReport whole = verify::verify_scene(scene, settings);
    CHECK(whole.configurations.size() == all);
    CHECK(whole.left_out == 0);
    REQUIRE(told.size() == 1);
    CHECK(told[0].scene == "cornell");
    CHECK(told[0].configuration == whole.configurations[1].label);
    CHECK(told[0].failure.stage == "bounce0/level0/intersect_root");
    CHECK_THAT(told[0].replay, ContainsSubstring("--stage 'bounce0/level0/intersect_root'"));

    told.clear();
    settings.fail_fast = true;
    const SceneReport ended = verify::verify_scene(scene, settings);
    CHECK(told.size() == 1);
    CHECK(ended.configurations.size() == 2);
    CHECK(ended.left_out == all - 2);
    CHECK_FALSE(ended.passed());
}

TEST_CASE("verify: what asks to stop is asked after every launch, and what was judged is reported",
          "[verify][sweep]") {
    const Scene scene = scenes::load_scene("cornell");
    VerifySettings settings = quick();
    settings.oracles = false;
    settings.threads = 1;
    const std::size_t all = verify::all_configurations(settings).size();
    std::size_t asked = 0;
    settings.stop = [&] { return ++asked > 30; };
    const SceneReport report = verify::verify_scene(scene, settings);
    CHECK(report.configurations.size() < all);
    CHECK(report.configurations.size() + report.left_out == all);
    for (const auto& one : report.configurations) CHECK(one.counts.stages > 0);
}

TEST_CASE("verify: configurations that run at a time say what they say one by one",
          "[verify][sweep]") {
    const Scene scene = scenes::load_scene("furnace");
    VerifySettings settings = quick();
    settings.filter.schedule = {emulation::parse_schedule("linear")};
    const SceneReport together = verify::verify_scene(scene, settings);
    settings.threads = 1;
    const SceneReport alone = verify::verify_scene(scene, settings);
    REQUIRE(together.configurations.size() == alone.configurations.size());
    for (std::size_t i = 0; i < alone.configurations.size(); ++i) {
        CHECK(together.configurations[i].label == alone.configurations[i].label);
        CHECK(together.configurations[i].counts.pushes == alone.configurations[i].counts.pushes);
        CHECK(together.configurations[i].rays == alone.configurations[i].rays);
    }
    CHECK(together.passed());
}

}  // namespace
