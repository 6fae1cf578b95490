/// scotty analyze as a user runs it, and what it counts and times.
#include <nlohmann/json.hpp>

#include "tests/catch.h"
#include "tests/verify/analysis_runs.h"
#include "tests/verify/command_tools.h"
#include "verify/analysis/analysis_census.h"
#include "verify/analysis/analysis_measure.h"
#include "verify/analysis/analysis_renders.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;

AnalysisSettings tiny() {
    AnalysisSettings settings;
    settings.render.parameters.image_width = 8;
    settings.render.parameters.image_height = 6;
    settings.render.parameters.spp = 2;
    settings.render.repeats = 1;
    settings.render.warm_ups = 0;
    settings.keep_size = true;
    return settings;
}

TEST_CASE("analyze: all analyses are carried out, and each has what its figure needs",
          "[verify][analysis]") {
    AnalysisSettings settings = tiny();
    std::size_t finished = 0;
    settings.finished = [&](const AnalysisRun& run) { finished = run.results.size(); };
    const AnalysisRun run = analyze(scenes::load_scene("cornell"), settings);
    REQUIRE(run.results.size() == analysis_catalog().size());
    CHECK(finished == run.results.size());
    for (const AnalysisResult& result : run.results) {
        INFO(result.name);
        for (const AnalysisSeries& series : result.series) CHECK_FALSE(series.points.empty());
    }
    const AnalysisSeries& rays = run.find("rays")->named(0, "");
    CHECK(rays.points[0].x == 8.0 * 6);
    CHECK(rays.points.back().x == 8.0 * 6 * 16);
    CHECK(run.find("levels")->parameters.max_leaf_size == 32);
    const AnalysisPoint& primary = run.find("bounces")->named(0, "").points[0];
    CHECK(primary.label == "primary");
    CHECK(primary.column("rays") == 8.0 * 6 * 2);
    CHECK(primary.column("entries per ray") > 1.0);  // the root's, and some below
}

TEST_CASE("analyze: only what was asked for, and what is finished is kept at a stop",
          "[verify][analysis]") {
    AnalysisSettings settings = tiny();
    settings.names = {"width", "stages", "width"};
    const reference::Scene scene = scenes::load_scene("cornell");
    const AnalysisRun run = analyze(scene, settings);
    REQUIRE(run.results.size() == 2);
    CHECK(run.results[0].name == "width");
    bool stop = false;
    settings.finished = [&](const AnalysisRun&) { stop = true; };
    settings.stop = [&] { return stop; };
    settings.names = {"width", "rays-per-block"};
    CHECK(analyze(scene, settings).results.size() == 1);
    settings.names = {"nonsense"};
    CHECK_THROWS_WITH(analyze(scene, settings),
                      ContainsSubstring("'nonsense'") && ContainsSubstring("early-out"));
}

TEST_CASE("analyze: the variants of a sweep take turns, and each has its repeats",
          "[verify][analysis]") {
    RenderSettings settings = tiny().render;
    settings.repeats = 2;
    std::vector<std::string> order;
    settings.progress = [&](const std::string& what) { order.push_back(what); };
    const reference::Scene scene = scenes::load_scene("cornell");
    AnalysisRenders renders(scene, settings, {});
    reference::PipelineParameters wide = settings.parameters;
    wide.width = 16;
    const auto rounds = renders.by_turns({settings.parameters, wide});
    CHECK(order ==
          std::vector<std::string>{"round 1 of 2, render 1 of 2", "round 1 of 2, render 2 of 2",
                                   "round 2 of 2, render 1 of 2", "round 2 of 2, render 2 of 2"});
    REQUIRE(rounds.size() == 2);
    for (const RenderRounds& one : rounds) {
        CHECK(one.seconds.size() == 2);
        const auto all = one.sums([](const auto&) { return true; });
        const auto none = one.sums([](const auto&) { return false; });
        REQUIRE(all.size() == 2);
        CHECK(all[1] > 0.0);
        CHECK(all[1] <= one.seconds[1]);
        CHECK(none[1] == 0.0);
    }
    settings.parameters.spp = 1u << 20;
    settings.parameters.image_width = settings.parameters.image_height = 64;
    CHECK_THROWS_WITH(renders.device_bytes(settings.parameters),
                      ContainsSubstring("can be in a traversal"));
}

TEST_CASE("census: blocks are those of the launches, and a traversal run again counts once",
          "[verify][analysis]") {
    const reference::Scene scene = scenes::load_scene("coil");
    reference::PipelineParameters p = tiny().render.parameters;
    p.hit_capacity = 1;  // has to grow: traversals are run again
    p.early_out = reference::EarlyOut::off;
    p.rays_per_block = 32;
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 0));
    const auto counted = [&](QueueCensus& census, std::uint32_t capacity) {
        p.hit_capacity = capacity;
        emulation::Pipeline pipeline(scene, bvh, p, {}, &census);
        pipeline.render();
        return pipeline.launches();
    };
    QueueCensus grown(32);
    QueueCensus census(32);
    counted(grown, 1);
    const auto launches = counted(census, 64);
    CHECK(entries_of(grown.queries()) == entries_of(census.queries()));
    REQUIRE(census.queries()[0].primary());
    CHECK(census.queries()[0].rays == 8u * 6 * 2);
    CHECK(census.queries()[0].levels[0].blocks == 3);  // 96 rays, 32 a block
    std::uint64_t blocks = 0;
    std::uint64_t entries = 0;
    for (const auto& launch : launches) {
        if (launch.kind != reference::StageKind::intersect &&
            launch.kind != reference::StageKind::intersect_root) {
            continue;
        }
        blocks += launch.blocks;
        entries += launch.items;
    }
    std::uint64_t found = 0;
    for (const QueryCensus& query : census.queries()) {
        for (const LevelCensus& level : query.levels) {
            found += level.blocks;
            CHECK(level.all_slots == level.nodes * 3);
            CHECK(level.blocks <= level.all_slots);
        }
    }
    CHECK(found == blocks);
    CHECK(entries_of(census.queries()) == entries);
    // Another size of block is another number of blocks: the comparison can fail.
    QueueCensus wrong(64);
    counted(wrong, 64);
    CHECK(wrong.queries()[0].levels[0].blocks == 2);
}

TEST_CASE("analyze: the command writes page, figures and JSON, and draws them again from it",
          "[verify][analysis][command]") {
    const TemporaryFolder folder;
    const Result first = scotty_here(
        "analyze cornell --size 8x6 --spp 1 --repeats 1 --warm-ups 0 --analysis width "
        "--analysis strided -o " +
        folder.file("a"));
    INFO(first.err);
    REQUIRE(first.exit_code == kExitPassed);
    CHECK_THAT(first.out,
               ContainsSubstring("Tree width (width)") && ContainsSubstring("kernels, ms"));
    const std::string page = slurp(folder / "a/analysis.html");
    CHECK_THAT(page, StartsWith("<!doctype html>") && ContainsSubstring("paper, GTX 1080 Ti"));
    CHECK_THAT(slurp(folder / "a/strided.svg"), StartsWith("<svg"));
    CHECK_FALSE(std::filesystem::exists(folder / "a/rays.svg"));

    const std::string json = folder.file("a/analysis.json");
    const Result again = scotty_here("analyze --from " + json + " -o " + folder.file("b"));
    REQUIRE(again.exit_code == kExitPassed);
    CHECK(slurp(folder / "b/analysis.html") == page);
    CHECK(slurp(folder / "b/analysis.json") == slurp(json));
    const Result both = scotty_here("analyze --json --from " + json + " --from " + json + " -o " +
                                    folder.file("c"));
    REQUIRE(both.exit_code == kExitPassed);
    CHECK(nlohmann::json::parse(both.out)["runs"].size() == 2);
}

TEST_CASE("analyze: bad input says what is wrong, and a device that is not there is exit 3",
          "[verify][analysis][command]") {
    const TemporaryFolder folder;
    const std::string into = " -o " + folder.file("out");
    const Result name = scotty_here("analyze --analysis speed" + into);
    CHECK(name.exit_code == kExitUsage);
    CHECK_THAT(name.err, ContainsSubstring("'speed'") && ContainsSubstring("rays-per-block") &&
                             ContainsSubstring("memory"));
    const std::string whole = to_json({made_run("one")}).dump();
    spill(folder / "cut.json", whole.substr(0, whole.size() / 2));
    const Result cut = scotty_here("analyze --from " + folder.file("cut.json") + into);
    CHECK(cut.exit_code == kExitUsage);
    CHECK_THAT(cut.err, ContainsSubstring("cut.json") && ContainsSubstring("cut short"));
    CHECK(scotty_here("analyze --from " + folder.file("none.json") + into).exit_code == kExitUsage);
    CHECK(scotty_here("analyze --backend vulkan" + into).exit_code == kExitUsage);
    CHECK(scotty_here("analyze --size 65536x65536 --spp 8" + into).exit_code == kExitUsage);
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
    if (!std::filesystem::exists("/dev/nvidia0")) {
        const Result cuda = scotty_here("analyze --backend cuda --size 8x6 --spp 1" + into);
        CHECK(cuda.exit_code == kExitMissingEnvironment);
    }
}

}  // namespace
