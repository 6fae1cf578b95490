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

/// Two squares that glow and light each other: all that is met is both lit and a light.
PipelineInput glowing_squares(const reference::PipelineParameters& p) {
    const TemporaryFolder folder;
    spill(folder / "a.mtl", "newmtl glow\nKd 0.6 0.3 0.1\nKe 0.7 1.3 2.9\n");
    spill(folder / "a.obj",
          "mtllib a.mtl\nusemtl glow\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n"
          "v -1 -1 3\nv -1 1 3\nv 1 1 3\nv 1 -1 3\nf 5 6 7 8\n");
    PipelineInput input;
    input.scene = scenes::load_scene((folder / "a.obj").string());
    input.scene.camera.position = reference::Vec3(0.0f, 0.0f, 2.5f);
    input.scene.camera.forward = reference::Vec3(0.0f, 0.0f, -1.0f);
    input.scene.camera.right = reference::Vec3(1.0f, 0.0f, 0.0f);
    input.scene.camera.up = reference::Vec3(0.0f, 1.0f, 0.0f);
    input.bvh = build_wide_bvh(input.scene, bvh_parameters(p, 0));
    input.parameters = p;
    return input;
}

TEST_CASE("simt: light and emission of a vertex add up in the stages' order where nobody watches",
          "[verify][simt]") {
    reference::PipelineParameters p = small_parameters();
    p.queue_levels = 1;
    p.spp = 4;
    for (const std::uint32_t lights : {0u, 1u, 2u, 3u}) {
        for (const std::uint32_t bounces : {0u, 2u}) {
            INFO(lights << " lights, " << bounces << " bounces");
            p.light_samples = lights;
            p.bounces = bounces;
            p.batch_rays = 100;
            const PipelineInput input = glowing_squares(p);
            const reference::Image expected = backend_named("emulator", 1).render(input, nullptr);
            const reference::Image found = backend_named("simt", 1).render(input, nullptr);
            CHECK(found.pixels == expected.pixels);
            CHECK(found.variance == expected.variance);
            CHECK(reference::max_component(expected.pixels[70]) > 1.0f);
        }
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
