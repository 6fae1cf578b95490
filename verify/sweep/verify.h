/// The verification of scenes: baseline, oracles, and every other configuration against both.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "verify/golden/hash_book.h"
#include "verify/report/report.h"
#include "verify/sweep/cases.h"
#include "verify/sweep/configurations.h"

namespace scotty::verify {

struct VerifySettings {
    /// What all configurations share: image, samples, bounces, seed, leaf size.
    reference::PipelineParameters parameters;
    ConfigurationFilter filter;
    /// Where there is a value: run these beside the baseline, and not what the filter selects.
    std::optional<std::vector<Configuration>> only;
    std::size_t threads = 0;  ///< 0: all of the machine
    /// Who runs all configurations. Any but the emulator is compared with it besides, launch by
    /// launch.
    std::string backend = "emulator";
    bool check = false;  ///< this program checks what kernels touch (--check); noted for replays
    std::string plant;   ///< the fault that is planted in this program; noted for replays
    std::string stage_pattern;  ///< judge these stages only
    bool oracles = true;
    /// Every configuration also under so many schedules (schedule_check.h); 0: under its own only.
    std::size_t schedules = 0;
    /// Which runs are this shard's, by their numbers over all scenes; empty: all. The baseline of a
    /// scene is run where any of its runs is, as the others are compared with it.
    std::function<bool(std::size_t unit)> has_unit;
    std::size_t first_unit = 0;                     ///< number of the scene's baseline
    std::uint64_t brute_force_tests = 400'000'000;  ///< see HitCheckSettings
    /// Where all else agrees: is it what it was when somebody approved it? Null: not asked.
    HashBook* hashes = nullptr;
    /// Called before each step: what is being done, steps done, steps in all.
    std::function<void(const std::string& what, std::size_t done, std::size_t total)> progress;
    /// Called once, as soon as something fails: with the failure that leads in its configuration.
    std::function<void(const PlacedFailure& first)> on_first_failure;
    bool fail_fast = false;  ///< nothing more is run after a configuration or an oracle has failed
    /// Asked after every launch: true ends the run, and the configuration that is under way is not
    /// reported.
    std::function<bool()> stop;
    /// For tests of the verification itself: stands between a pipeline and everything that looks
    /// at it, and may show them something else. `configuration` 0 is the baseline.
    using Tamper =
        std::function<void(const reference::StageView& stage, std::size_t configuration,
                           const std::function<void(const reference::StageView&)>& show)>;
    Tamper tamper;
};

/// A small image of an odd shape with two samples: enough rays for several blocks of every size,
/// quick enough for a minute over all built-in scenes.
reference::PipelineParameters default_verify_parameters();

/// What is run of each scene: the baseline, then what the settings ask for.
std::vector<Configuration> all_configurations(const VerifySettings& settings);
/// How many runs a scene has, the baseline among them.
std::size_t units_of_scene(const VerifySettings& settings);

/// Never throws for a failed check: those are in the report.
SceneReport verify_scene(const reference::Scene& scene, const VerifySettings& settings);

/// Of a scene that is known to be valid, and that yet cannot be loaded or run: that is a failure.
SceneReport refused_scene(const std::string& scene, const std::string& why);

/// Each case against the baseline of its own picture, and that against the oracles. One
/// configuration in the report a case: its counts are of both runs. `settings` says how they run;
/// its picture and its filter do not count.
SceneReport verify_cases(const std::vector<Case>& cases, const VerifySettings& settings);

}  // namespace scotty::verify
