#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reference/error.h"
#include "scenes/scenes.h"
#include "tests/verify/command_tools.h"
#include "verify/bench.h"
#include "verify/bench_check.h"
#include "verify/bench_simt.h"
#include "verify/options.h"

namespace {

namespace fs = std::filesystem;
using namespace scotty;
using Catch::Matchers::Contains;

TEST_CASE("bench: the median is the middle one, the lower of two", "[verify][bench]") {
    CHECK(verify::median({3.0}) == 3.0);
    CHECK(verify::median({5.0, 1.0, 3.0}) == 3.0);
    CHECK(verify::median({4.0, 1.0, 3.0, 2.0}) == 2.0);
    CHECK_THROWS_AS(verify::median({}), reference::Error);
}

TEST_CASE("bench: both tracers get the living rays of every traversal", "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters.image_width = 16;
    settings.parameters.image_height = 8;
    settings.parameters.spp = 1;
    settings.parameters.bounces = 1;
    settings.repeats = 2;
    settings.warm_ups = 0;
    const verify::BenchReport report = bench_emulator(scenes::load_scene("cornell"), settings);
    REQUIRE(report.kinds.size() == 3);
    CHECK(report.kinds[0].kind == "primary");
    CHECK(report.kinds[0].rays == 16u * 8);
    CHECK(report.kinds[1].kind == "shadow");
    CHECK(report.kinds[2].kind == "bounce 1");
    std::uint64_t rays = 0;
    double ours = 0.0;
    for (const verify::BenchRays& kind : report.kinds) {
        rays += kind.rays;
        ours += kind.emulator_seconds;
        CHECK(kind.embree_seconds > 0.0);
    }
    CHECK(report.all.rays == rays);
    CHECK(report.all.emulator_seconds == ours);
    CHECK(to_json(report)["ratio_to_embree"].get<double>() == report.all.ratio());
    CHECK(report.device_bytes > 16u * 8 * 32);
}

TEST_CASE("bench: the CUDA text on the CPU is timed beside the emulator, stage by stage",
          "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters.image_width = 16;
    settings.parameters.image_height = 8;
    settings.parameters.spp = 1;
    settings.repeats = 2;
    const verify::SimtBenchReport report = bench_simt(scenes::load_scene("cornell"), settings);
    CHECK(report.render.emulator_seconds > 0.0);
    CHECK(report.render.simt_seconds > 0.0);
    CHECK(report.stages.size() == 10);
    double parts = 0.0;
    for (const verify::SimtBenchPart& part : report.stages) {
        CHECK(part.simt_seconds > 0.0);
        parts += part.simt_seconds;
    }
    CHECK(parts <= report.render.simt_seconds);
    CHECK(to_json(report)["ratio_to_emulator"].get<double>() == report.render.ratio());
    CHECK_THAT(table(report), Contains("whole render") && Contains("intersect_root"));
}

TEST_CASE("bench: checking that costs more than its limit fails", "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters.image_width = 16;
    settings.parameters.image_height = 8;
    settings.parameters.spp = 1;
    settings.repeats = 1;
    const reference::Scene scene = scenes::load_scene("cornell");
    const auto with = [&](const std::string& emulator, const std::string& simt) {
        return bench_check(scene, settings,
                           R"(echo '{"emulator":[)" + emulator + R"(],"simt":[)" + simt + "]}'");
    };
    CHECK(with("1e-9", "1e-9").passed());
    CHECK_FALSE(with("1e-9", "1e9").passed());
    const verify::CheckBenchReport slow = with("1e9", "1e-9");
    CHECK_FALSE(slow.passed());
    REQUIRE(slow.parts.size() == 2);
    CHECK_FALSE(slow.parts[0].within());
    CHECK(slow.parts[1].within());
    CHECK(to_json(slow)["passed"] == false);
    CHECK_THAT(table(slow), Contains("OVER THE LIMIT"));
    CHECK_THROWS_WITH(bench_check(scene, settings, "true"), Contains("no figures from true"));
}

TEST_CASE("bench: the command fails with the limit, exit code 1", "[verify][bench][cli]") {
    const verify::test::TemporaryFolder folder;
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    fs::copy_file(here / "scotty", folder / "scotty");
    // What scotty-checked would print, had it taken that long.
    std::ofstream(folder / "scotty-checked")
        << "#!/bin/sh\necho '{\"emulator\":[1e-9],\"simt\":[1e9]}'\n";
    fs::permissions(folder / "scotty-checked", fs::perms::owner_all);
    const verify::test::Result result = verify::test::run(
        folder / "scotty", "bench check cornell --size 16x8 --repeats 1 --json -");
    INFO(result.err);
    CHECK(result.exit_code == 1);
    CHECK(nlohmann::json::parse(result.out)["passed"] == false);
}

TEST_CASE("options: a size is two numbers around an x", "[verify][options]") {
    reference::PipelineParameters p;
    verify::parse_size("640x480", p);
    CHECK(p.image_width == 640);
    CHECK(p.image_height == 480);
    for (const char* text :
         {"640", "640x", "x480", "640x480x3", "6 40x480", "-1x5", "99999999999x1"}) {
        CHECK_THROWS_WITH(verify::parse_size(text, p), Contains("--size"));
    }
}

TEST_CASE("options: a list is values between commas", "[verify][options]") {
    CHECK(verify::split_list("--width", "2,4,16") == std::vector<std::string>{"2", "4", "16"});
    CHECK(verify::split_list("--width", "8").size() == 1);
    for (const char* text : {"", ",", "2,", ",4"}) {
        CHECK_THROWS_WITH(verify::split_list("--width", text), Contains("--width"));
    }
}

}  // namespace
