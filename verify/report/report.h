/// What `scotty verify` found out, and the forms in which it says so.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "verify/capture/failure.h"
#include "verify/invariants/invariants.h"
#include "verify/oracles/hit_check.h"
#include "verify/report/coverage.h"
#include "verify/report/mutant_report.h"
#include "verify/report/report_images.h"

namespace scotty::verify {

/// Stages of a back end held against the emulator's.
struct StageCounts {
    std::uint64_t identical = 0;
    std::uint64_t reordered = 0;
    std::uint64_t within_bounds = 0;
    std::uint64_t differ = 0;

    std::uint64_t all() const { return identical + reordered + within_bounds + differ; }
    StageCounts& operator+=(const StageCounts& other);
};

struct ConfigurationReport {
    std::string label;
    std::size_t unit = 0;  ///< its number in the whole sweep (VerifySettings::first_unit)
    StageCounts stages;    ///< all zero where the emulator is what is verified
    InvariantCounts counts;
    std::uint64_t rays = 0;     ///< living rays traced
    std::size_t schedules = 0;  ///< under which it ran besides its own
    double seconds = 0.0;
    std::vector<Failure> failures;  ///< invariants first, then differences from the baseline
    std::string replay;             ///< command that runs this configuration on this scene alone
};

struct SceneReport {
    std::string scene;   ///< its name
    std::string source;  ///< what was asked for
    std::uint64_t triangles = 0;
    std::vector<std::string> warnings;
    std::vector<ConfigurationReport> configurations;  ///< the baseline first
    std::vector<Failure> bvh_failures;
    bool oracles_ran = false;
    HitCheckResult hits;
    ImageCheckResult image;
    double oracle_seconds = 0.0;
    double seconds = 0.0;
    /// Runs that were to be made and were not (VerifySettings::fail_fast, stop).
    std::size_t left_out = 0;

    std::uint64_t rays() const;  ///< of all configurations
    bool passed() const;
};

/// A place in the kernels where memory is read that others may change meanwhile (load_relaxed).
struct RelaxedRead {
    std::string line;       ///< "gpu/kernels/intersect.h:207"
    std::uint64_t met = 0;  ///< how often an atomic of the same launch met it, unordered
};

struct Report {
    reference::PipelineParameters parameters;  ///< what all configurations share
    std::size_t threads = 0;
    std::string backend = "emulator";
    std::string command;  ///< as given
    std::vector<SceneReport> scenes;
    std::optional<Coverage> coverage;  ///< of the cases, where they were run
    std::vector<ImageCase> images;     ///< against their golden images
    /// What is wrong with the golden files themselves: missing, stale, corrupted, waivers that have
    /// expired. `stage` names the case.
    std::vector<Failure> golden_failures;
    /// Golden images that were not judged because of them, by their number in the whole sweep.
    std::vector<std::size_t> unjudged_units;
    bool checked = false;                      ///< --check
    std::vector<RelaxedRead> relaxed_reads{};  ///< where checked: by line
    /// Probability that all these images together fail though nothing is wrong.
    double false_alarm = 0.0;
    double seconds = 0.0;
    /// Why not all that was asked for was judged: "Ctrl-C", or the first failure (--fail-fast).
    /// Empty: all was. What was not judged has not passed.
    std::string stopped{};
    std::optional<MutantReport> mutants;  ///< where `scotty report` was given them

    bool passed() const;
    /// No scene had a stage that was judged: a --stage that matches none, or nothing but images.
    bool judged_no_stage() const;
};

/// A failure with the configuration in which it arose and the command that shows it again.
struct PlacedFailure {
    std::string scene;
    std::string configuration;
    Failure failure;
    std::string replay;
    std::string approve;  ///< of an image only: the command that makes it the golden one
};
/// The one that leads: the first scene's first, a broken BVH before the baseline's invariants,
/// those before the other configurations', the oracles last; after all scenes the images. Empty
/// where everything passed.
std::vector<PlacedFailure> placed_failures(const Report& report);
/// The same of one scene, without the images.
std::vector<PlacedFailure> placed_failures(const SceneReport& scene);

/// The table that ends `scotty verify`, with the leading failure below it and the others by kind
/// (failure_groups.h); no wider than 80 columns but for failures and commands.
std::string table(const Report& report);
nlohmann::json to_json(const Report& report);
std::string to_junit(const Report& report);
/// One file, no network: verdicts, failures, and images to be looked into (verify/pages/web/).
std::string to_html(const Report& report);

}  // namespace scotty::verify
