/// Stages run alone: a captured run replays to itself, and what was spoiled is found.
#include <cmath>
#include <map>
#include <set>

#include "emulation/host/pipeline.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/replay_inputs.h"
#include "verify/diff/replay.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

Backend emulator() { return backend_named("emulator", 0); }

/// The buffers that a replay found different.
std::set<std::string> differing(const DiffReport& report) {
    std::set<std::string> names;
    for (const StageResult& stage : report.stages) {
        for (const BufferResult& buffer : stage.buffers) {
            if (buffer.verdict == Verdict::differs) names.insert(buffer.name);
        }
    }
    return names;
}

TEST_CASE("replay: every stage alone gives what the run gave", "[verify][replay]") {
    PipelineParameters p = small_parameters();
    p.light_samples = 2;
    p.filter = Filter::median;
    SECTION("as it is") {}
    SECTION("early-out off, strided, width 16") {
        p.early_out = EarlyOut::off;
        p.block_order = BlockOrder::strided;
        p.width = 16;
    }
    SECTION("packed hits, width 2, gaussian") {
        p.hit_mode = HitMode::packed;
        p.width = 2;
        p.filter = Filter::gaussian;
    }
    SECTION("several batches that split pixels, closest shadow queries, width 8, bilateral") {
        p.batch_rays = 97;
        p.spp = 3;
        p.width = 8;
        p.shadow_query = ShadowQuery::closest;
        p.filter = Filter::bilateral;
    }
    SECTION("passes of two samples, the last of one, in batches that split the image") {
        p.batch_rays = 97;
        p.spp = 5;
        p.samples_per_pass = 2;
    }
    SECTION("no light samples") { p.light_samples = 0; }
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", p);
    const DiffReport report = diff_isolated(capture, emulator(), {});
    INFO(to_text(report));
    CHECK(report.passed());
    CHECK(report.isolated);
    CHECK(report.stages.size() == capture.stages().size());
    std::set<StageKind> kinds;
    for (const StageResult& stage : report.stages) {
        kinds.insert(stage.kind);
        CHECK_FALSE(stage.buffers.empty());
    }
    CHECK(kinds.count(StageKind::filter) == 1);
    CHECK(kinds.count(StageKind::intersect) == 1);
}

TEST_CASE("replay: early-out immediate replays, hits and radiance are compared bit for bit",
          "[verify][replay][immediate]") {
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::immediate;
    const TemporaryFolder folder;
    const DiffReport report = diff_isolated(make_capture(folder / "c", p), emulator(), {});
    INFO(to_text(report));
    CHECK(report.passed());
}

TEST_CASE("replay: a fresh run from a capture's input gives the capture", "[verify][replay]") {
    PipelineParameters p = small_parameters();
    p.hit_capacity = 1;  // the run is one with retries
    p.early_out = EarlyOut::off;
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", p);
    const DiffReport report = diff_with_run(capture, emulator(), {});
    INFO(to_text(report));
    CHECK(report.passed());
    CHECK(report.stages.size() == capture.stages().size());
    CHECK(report.b_backend == "emulator");
}

/// Spoils one output of one stage of each kind; a replay of that stage must find it, and an
/// isolated diff no other.
TEST_CASE("replay: a spoiled output of any kind of stage is found there and nowhere else",
          "[verify][replay]") {
    PipelineParameters p = small_parameters();
    p.filter = Filter::median;
    const std::map<std::string, std::string> spoiled{
        {"primary_rays", "throughput"},
        {"bounce0/level1/scan_counts", "block_offsets"},
        {"bounce0/level0/intersect_root", "child_counts"},
        {"bounce0/level1/intersect", "child_counts"},
        {"bounce0/level2/publish_minimum", "minimum"},
        {"bounce0/merge_intersections", "merged"},
        {"bounce0/light0/direct_light_rays", "potential"},
        {"bounce0/light0/resolve_light", "radiance"},
        {"bounce0/scene_rays", "depth"},
        {"reconstruct_image", "image"},
        {"filter_median", "filtered"}};
    for (const auto& [stage, buffer] : spoiled) {
        INFO(stage << " " << buffer);
        const TemporaryFolder folder;
        const std::string name = stage;
        const std::string output = buffer;
        const Capture capture = make_capture(folder / "c", p, [&](StageCopies& stages) {
            ++stages.at(name).output<std::uint32_t>(output)[1];
        });
        const DiffReport alone = replay_stage(capture, name, emulator());
        CHECK_FALSE(alone.passed());
        CHECK(alone.stages.size() == 1);
        CHECK(differing(alone).count(output) == 1);
        const DiffReport all = diff_isolated(capture, emulator(), {});
        REQUIRE(all.first() != nullptr);
        CHECK(all.first()->stage == name);
    }
}

TEST_CASE("replay: isolated tells the wrong kernel from those that were handed its data",
          "[verify][replay]") {
    const TemporaryFolder folder;
    // As if a broken kernel had lost a ray: all that follows is right, given that.
    const Capture capture = make_capture(folder / "c", small_parameters(), [](StageCopies& stages) {
        for (const char* name : {"bounce0/light0/resolve_light", "bounce0/scene_rays"}) {
            for (Vec3& radiance : stages.at(name).output<Vec3>("radiance")) radiance.r += 1.0f;
        }
    });
    const DiffReport report = diff_isolated(capture, emulator(), {});
    std::vector<std::string> failed;
    for (const StageResult& stage : report.stages) {
        if (stage.failed()) failed.push_back(stage.name);
    }
    // The next to show radiance is the resolve of bounce 1, which was not spoiled.
    CHECK(failed ==
          std::vector<std::string>{"bounce0/light0/resolve_light", "bounce1/light0/resolve_light"});
}

TEST_CASE("replay: of a part of a run, the stage that is missing is named",
          "[verify][replay][errors]") {
    const TemporaryFolder folder;
    const auto error = [&](const std::string& stage, const std::vector<std::string>& also = {}) {
        std::vector<std::string> patterns = also;
        patterns.push_back(stage);
        const Capture capture = make_capture(folder / "c", small_parameters(), {}, {}, patterns);
        return error_of([&] { replay_stage(capture, stage, emulator()); });
    };
    CHECK_THAT(error("bounce0/level1/intersect"),
               ContainsSubstring("needs hit_counts as bounce0/level0/intersect_root left it") &&
                   ContainsSubstring("capture it too") && ContainsSubstring("--stages"));
    CHECK(error("bounce0/level1/intersect", {"bounce0/level0/intersect_root"}) == "(no error)");
    CHECK_THAT(error("bounce1/scene_rays", {"primary_rays", "bounce0/scene_rays"}),
               ContainsSubstring("radiance as bounce1/light0/resolve_light left it"));
    CHECK_THAT(error("bounce0/light0/direct_light_rays"),
               ContainsSubstring("pixel as primary_rays left it"));
    CHECK(error("bounce0/merge_intersections") == "(no error)");
    CHECK(error("reconstruct_image") == "(no error)");
}

TEST_CASE("replay: an unknown stage or back end is answered with those there are",
          "[verify][replay][errors]") {
    const TemporaryFolder folder;
    const Capture capture =
        make_capture(folder / "c", small_parameters(), {}, {}, {"primary_rays"});
    CHECK_THAT(error_of([&] { replay_stage(capture, "bounce9/scene_rays", emulator()); }),
               ContainsSubstring("holds no stage 'bounce9/scene_rays'") &&
                   ContainsSubstring("primary_rays"));
    CHECK_THAT(error_of([] { backend_named("abacus", 0); }),
               ContainsSubstring("expected one of emulator") && ContainsSubstring("'abacus'"));
    std::filesystem::remove_all(folder / "c" / "input");
    CHECK_THAT(error_of([&] { replay_stage(capture, "primary_rays", emulator()); }),
               ContainsSubstring("expected a pipeline input"));
}

/// A prepared stage with one input spoiled, run by the emulator.
std::string run_error(const char* stage, const char* buffer, std::size_t index,
                      std::uint32_t value) {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters());
    LoadedStage prepared = prepare_stage(capture, *capture.find(stage));
    bool found = false;
    for (BufferView& view : prepared.view.inputs) {
        if (view.name != buffer) continue;
        static_cast<std::uint32_t*>(const_cast<void*>(view.data))[index] = value;
        found = true;
    }
    REQUIRE(found);
    const PipelineInput input = read_pipeline_input(folder / "c");
    return error_of([&] {
        emulation::Pipeline(input.scene, input.bvh, input.parameters).run_stage(prepared.view);
    });
}

TEST_CASE("replay: inputs that would lead a kernel out of its buffers are refused by name",
          "[verify][replay][errors]") {
    const char* const level = "bounce0/level1/intersect";
    CHECK_THAT(run_error(level, "queue", 0, 286),
               ContainsSubstring(level) && ContainsSubstring("queue") &&
                   ContainsSubstring("has ray 286, there are 286"));
    CHECK_THAT(run_error(level, "block_offsets", 1, 1000), ContainsSubstring("block_offsets"));
    CHECK_THAT(run_error(level, "child_offsets", 1, 0xffffff), ContainsSubstring("child_offsets"));
    CHECK_THAT(run_error(level, "queue_offsets", 0, 0xffffff), ContainsSubstring("queue_offsets"));
    CHECK_THAT(run_error(level, "node_counts", 0, 0xffffff), ContainsSubstring("block_offsets"));
    CHECK_THAT(run_error("bounce0/level0/intersect_root", "node_counts", 0, 3),
               ContainsSubstring("intersect_root"));
    CHECK_THAT(run_error("bounce0/scene_rays", "path_hits", 1, 999999),
               ContainsSubstring("path_hits") && ContainsSubstring("hits primitive 999999"));

    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters());
    const PipelineInput input = read_pipeline_input(folder / "c");
    LoadedStage prepared = prepare_stage(capture, *capture.find(level));
    std::erase_if(prepared.view.inputs, [](const BufferView& b) { return b.name == "rays"; });
    CHECK_THAT(
        error_of([&] {
            emulation::Pipeline(input.scene, input.bvh, input.parameters).run_stage(prepared.view);
        }),
        ContainsSubstring("rays") && ContainsSubstring("it is missing"));
}

TEST_CASE("replay: a stage that cannot be run is a failure of an isolated diff",
          "[verify][replay]") {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters(), [](StageCopies& stages) {
        stages.at("bounce0/level1/intersect").input<std::uint32_t>("queue")[0] = 100000;
    });
    const DiffReport report = diff_isolated(capture, emulator(), {});
    CHECK_FALSE(report.passed());
    REQUIRE(report.first() != nullptr);
    CHECK(report.first()->stage == "bounce0/level1/intersect");
    CHECK_THAT(report.first()->sentence,
               ContainsSubstring("could not be run") && ContainsSubstring("has ray 100000"));
}

}  // namespace
