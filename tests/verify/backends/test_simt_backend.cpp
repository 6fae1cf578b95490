/// The back end "simt": the CUDA text on the CPU, against captures of the emulator.
#include <algorithm>

#include "tests/verify/capture_tools.h"
#include "verify/backends/backend.h"
#include "verify/diff/replay.h"
#include "verify/sweep/verify.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;

TEST_CASE("simt: a run and every stage alone give what the emulator gave", "[verify][simt]") {
    reference::PipelineParameters p = small_parameters();
    SECTION("early-out level") {}
    SECTION("early-out immediate") { p.early_out = reference::EarlyOut::immediate; }
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", p);
    const Backend backend = backend_named("simt", 2);
    for (const DiffReport& report :
         {diff_with_run(capture, backend, {}), diff_isolated(capture, backend, {})}) {
        INFO(to_text(report));
        CHECK(report.passed());
        CHECK(report.b_backend == "simt");
        CHECK(report.stages.size() == capture.stages().size());
    }
}

TEST_CASE("simt: what was spoiled in a capture is found", "[verify][simt]") {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters(), [](StageCopies& stages) {
        ++stages.at("bounce0/level1/intersect").output<std::uint32_t>("child_counts")[1];
    });
    const DiffReport report = diff_isolated(capture, backend_named("simt", 1), {});
    CHECK_FALSE(report.passed());
    REQUIRE(report.first() != nullptr);
    CHECK(report.first()->stage == "bounce0/level1/intersect");
}

TEST_CASE("simt: verify finds where another back end parts from the emulator", "[verify][simt]") {
    VerifySettings settings;
    settings.parameters = small_parameters();
    settings.backend = "simt";
    settings.oracles = false;
    settings.filter.widths = {4};
    settings.filter.early_out = {reference::EarlyOut::off};
    // Both hold every invariant; only the comparison can tell.
    settings.tamper = [](const reference::StageView& stage, std::size_t,
                         const std::function<void(const reference::StageView&)>& show) {
        StageCopies copy;
        copy.on_stage(stage);
        if (stage.name == "bounce0/light0/direct_light_rays") {
            copy.at(stage.name).output<float>("potential")[0] += 0.25f;
        }
        show(copy.at(stage.name).view);
    };
    const SceneReport report = verify_scene(spheres_input(settings.parameters).scene, settings);
    CHECK_FALSE(report.passed());
    REQUIRE_FALSE(report.configurations.empty());
    for (const ConfigurationReport& c : report.configurations) {
        CHECK(c.stages.differ > 0);
        CHECK(std::any_of(c.failures.begin(), c.failures.end(), [](const Failure& failure) {
            return failure.invariant == "same-as-emulator" &&
                   failure.stage.ends_with("bounce0/light0/direct_light_rays");
        }));
    }
}

}  // namespace
