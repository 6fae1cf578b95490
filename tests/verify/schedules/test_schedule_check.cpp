/// Runs under several schedules: a planted dependence on the order, and a planted nondeterminism.
#include <vector>

#include "emulation/device/device.h"
#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "verify/schedules/schedule_check.h"
#include "verify/sweep/verify.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using emulation::seeded_schedules;
using reference::StageKind;
using reference::StageObserver;
using reference::StageView;

reference::PipelineParameters small_parameters() {
    reference::PipelineParameters p = default_verify_parameters();
    p.image_width = 17;
    p.image_height = 11;
    return p;
}

void show(StageObserver& observer, const char* name, std::uint32_t launch, StageKind kind,
          const std::vector<std::uint32_t>& words) {
    StageView stage;
    stage.name = name;
    stage.kind = kind;
    stage.launch = launch;
    stage.outputs = {reference::buffer_view("pixel", std::span<const std::uint32_t>(words), "")};
    observer.on_stage(stage);
}

/// Two launches; in the second the last block to come wins.
void last_block_wins(const emulation::Schedule& schedule, StageObserver& observer) {
    emulation::Device device({1, schedule.kind, schedule.seed});
    std::vector<std::uint32_t> words(1, 7);
    show(observer, "primary_rays", 0, StageKind::primary_rays, words);
    device.launch(5, 32, [&](const emulation::Block& block) { words[0] = block.index(); });
    show(observer, "bounce0/scene_rays", 1, StageKind::scene_rays, words);
}

TEST_CASE("schedules: a result of the order of blocks is named by schedule, stage and buffer",
          "[verify][schedules]") {
    const auto failures = check_schedules(seeded_schedules(4), small_parameters(), last_block_wins);
    REQUIRE(failures.size() == 3);
    CHECK(failures[0].invariant == "same-in-every-schedule");
    CHECK(failures[0].stage == "bounce0/scene_rays");
    CHECK(failures[0].field == "pixel");
    CHECK(failures[0].launch == 1);
    CHECK(failures[0].sentence == "schedule reversed gives what linear does not");
    CHECK(failures[1].sentence == "schedule strided gives what linear does not");
    CHECK(failures[2].sentence == "schedule adversarial gives what linear does not");
}

TEST_CASE("schedules: one that gives two results is stray nondeterminism, its first stage named",
          "[verify][schedules]") {
    std::uint32_t run = 0;
    const auto failures = check_schedules(
        seeded_schedules(1), small_parameters(),
        [&](const emulation::Schedule&, StageObserver& observer) {
            show(observer, "primary_rays", 0, StageKind::primary_rays, {1, 2});
            show(observer, "bounce0/scene_rays", 1, StageKind::scene_rays, {1, ++run});
            show(observer, "reconstruct_image", 2, StageKind::reconstruct_image, {run});
        });
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].invariant == "stray-nondeterminism");
    CHECK(failures[0].stage == "bounce0/scene_rays");
    CHECK(failures[0].field == "pixel");
    CHECK(failures[0].sentence == "schedule linear run twice gives two results");
}

TEST_CASE("schedules: a run that fails or ends early is told with its schedule",
          "[verify][schedules]") {
    const auto failures =
        check_schedules(seeded_schedules(2), small_parameters(),
                        [](const emulation::Schedule& schedule, StageObserver& observer) {
                            show(observer, "primary_rays", 0, StageKind::primary_rays, {1});
                            if (schedule.kind == emulation::ScheduleKind::reversed) {
                                throw reference::Error::internal("the queue overflowed");
                            }
                        });
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].invariant == "error");
    CHECK(failures[0].stage == "primary_rays");
    CHECK_THAT(failures[0].sentence,
               Catch::Matchers::ContainsSubstring("schedule reversed") &&
                   Catch::Matchers::ContainsSubstring("the queue overflowed"));
}

TEST_CASE("schedules: the pipeline is the same in all of them, retries and early-outs included",
          "[verify][schedules]") {
    VerifySettings settings;
    settings.parameters = small_parameters();
    settings.oracles = false;
    settings.schedules = 6;
    settings.filter.widths = {4};
    settings.filter.rays_per_block = {32};
    settings.filter.early_out = {reference::EarlyOut::level, reference::EarlyOut::immediate};
    settings.filter.shadow_query = {reference::ShadowQuery::any};
    settings.filter.hit_capacity = {1};
    settings.filter.schedule = {emulation::Schedule{}};
    for (const char* backend : {"emulator", "simt"}) {
        settings.backend = backend;
        const SceneReport report = verify_scene(scenes::load_scene("cornell"), settings);
        REQUIRE(report.configurations.size() >= 3);
        for (const ConfigurationReport& c : report.configurations) {
            INFO(backend << ": " << c.label);
            CHECK(c.failures.empty());
            CHECK(c.schedules == 6);
            CHECK_THAT(c.replay, Catch::Matchers::ContainsSubstring("--schedules 6"));
        }
    }
}

TEST_CASE("schedules: what a verification finds comes with the command that shows it again",
          "[verify][schedules]") {
    VerifySettings settings;
    settings.parameters = small_parameters();
    settings.oracles = false;
    settings.schedules = 3;
    settings.filter.widths = {8};
    settings.filter.early_out = {reference::EarlyOut::off};
    settings.filter.hit_mode = {reference::HitMode::packed};
    int renders = 0;
    // From the third run of a configuration on, one pixel is brighter.
    settings.tamper = [&](const StageView& stage, std::size_t,
                          const std::function<void(const StageView&)>& pass) {
        if (stage.kind == StageKind::primary_rays && stage.batch == 0) ++renders;
        const auto* radiance = stage.find("radiance");
        if (stage.kind != StageKind::resolve_light || stage.bounce != 1 || renders != 3) {
            return pass(stage);
        }
        const auto values = stage.get<reference::Vec3>("radiance");
        std::vector<reference::Vec3> spoiled(values.begin(), values.end());
        spoiled[5].x += 1.0f;
        StageView changed = stage;
        for (auto& buffer : changed.outputs) {
            if (buffer.name == radiance->name) buffer.data = spoiled.data();
        }
        pass(changed);
    };
    const SceneReport report = verify_scene(scenes::load_scene("cornell"), settings);
    const auto& failures = report.configurations.front().failures;
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].invariant == "stray-nondeterminism");
    CHECK(failures[0].stage == "bounce1/light0/resolve_light");
    CHECK(failures[0].field == "radiance");
    CHECK_FALSE(report.passed());
}

}  // namespace
