#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "reference/error.h"
#include "scenes/scenes.h"
#include "verify/bench.h"
#include "verify/bench_simt.h"
#include "verify/options.h"

namespace {

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
