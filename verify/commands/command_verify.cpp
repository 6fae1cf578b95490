/// scotty verify: is the pipeline right, on which scenes, in which configurations?
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "emulation/check/memory_checker.h"
#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "scenes/scenes.h"
#include "verify/backends/backend.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/base/stop_signal.h"
#include "verify/capture/capture_format.h"
#include "verify/capture/npy.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/commands/report_outputs.h"
#include "verify/golden/golden.h"
#include "verify/golden/golden_proposal.h"
#include "verify/golden/hash_book.h"
#include "verify/golden/verify_golden.h"
#include "verify/report/failure_groups.h"
#include "verify/report/report.h"
#include "verify/report/report_file.h"
#include "verify/sweep/crash_verdict.h"
#include "verify/sweep/verify.h"

namespace scotty::verify {
namespace {

/// Seconds in which something ends in any run of the built-in scenes, on any machine.
constexpr double kPatience = 300.0;

struct VerifyOptions {
    std::vector<std::string> scenes;
    bool all_scenes = false;  ///< none was named
    VerifySettings settings;
    BackendChoice backend;
    ReportOutputs outputs;
    std::string folder;
    bool require_gpu = false;
    std::optional<double> patience;  ///< seconds; where it is not said: of the built-in scenes only
    bool no_golden = false;
    bool only_golden = false;
    bool quick = false;
    bool thorough = false;
    std::string golden;
    std::string shard;
    std::string command_line;
    /// Says the first failure at once, to standard error: whoever waits for a verdict has it.
    bool announced = false;
    const StopSignals* signals = nullptr;

    void announce(const PlacedFailure& first) {
        if (std::exchange(announced, true)) return;
        spdlog::error("first failure: {}", to_text(first));
    }
    bool stopped_by_user() const { return signals != nullptr && signals->received() != 0; }

    /// The golden files are of whole scenes: not asked where some configurations or stages are. The
    /// exact tier would take minutes for what its comparison with the emulator says bit by bit.
    bool asks_golden() const {
        if (only_golden) return true;
        return !no_golden && !quick && backend.name != "simt" && !settings.filter.restricts() &&
               settings.stage_pattern.empty();
    }
    /// The cases bring their own scenes and pictures.
    bool asks_cases() const {
        return all_scenes && !only_golden && !settings.filter.restricts() &&
               settings.stage_pattern.empty();
    }
    Budget budget() const {
        return quick ? Budget::quick : thorough ? Budget::thorough : Budget::standard;
    }
};

/// What a sweep was asked for, by which its parts know each other.
nlohmann::ordered_json sweep_of(const VerifyOptions& options,
                                const std::vector<reference::Scene>& scenes) {
    const VerifySettings& settings = options.settings;
    nlohmann::ordered_json sweep{{"version", SCOTTY_VERSION},
                                 {"backend", options.backend.name},
                                 {"check", options.backend.check},
                                 {"plant", options.backend.plant},
                                 {"stage", settings.stage_pattern},
                                 {"oracles", settings.oracles},
                                 {"brute_force", settings.brute_force_tests},
                                 {"schedules", settings.schedules},
                                 {"golden", options.asks_golden()},
                                 {"only_golden", options.only_golden},
                                 {"quick", options.quick},
                                 {"thorough", options.thorough},
                                 {"cases", options.asks_cases()}};
    for (const Configuration& configuration : all_configurations(settings)) {
        sweep["configurations"].push_back(configuration.options());
    }
    sweep["parameters"] = verify::to_json(settings.parameters);
    for (const reference::Scene& scene : scenes) {
        sweep["scenes"].push_back({scene.source, hex_text(fingerprint(scene))});
    }
    return sweep;
}

void write_reports(const VerifyOptions& options, const Report& report,
                   const std::optional<ReportPart>& part) {
    if (!options.folder.empty()) {
        reference::write_file(options.folder + "/verify.json", to_json(report).dump(2) + "\n");
        reference::write_file(options.folder + "/verify.junit.xml", to_junit(report));
        reference::write_file(options.folder + "/verify.html", to_html(report));
        spdlog::info("report: {}/verify.html", options.folder);
    }
    write_report(options.outputs, report, part ? part_json(*part) : to_json(report));
}

GoldenSettings golden_settings(const VerifyOptions& options, std::size_t first_unit) {
    GoldenSettings golden;
    golden.folder = options.golden;
    golden.scenes = options.scenes;
    golden.threads = options.settings.threads;
    golden.has_unit = options.settings.has_unit;
    golden.first_unit = first_unit;
    return golden;
}

/// `left_out` runs or images were not made.
void note_stop(const VerifyOptions& options, std::size_t left_out, Report& report) {
    report.stopped =
        fmt::format("{}; {} runs or images of this scene were not made, and nothing after it",
                    options.stopped_by_user() ? "stopped by a signal"
                                              : "--fail-fast ended it at the first failure",
                    left_out);
}

void judge_golden_files(VerifyOptions& options, GoldenSettings golden, Report& report) {
    Progress progress;
    golden.stop = [&] {
        if (report.passed()) return options.stopped_by_user();
        progress.clear();
        options.announce(placed_failures(report).front());
        return options.settings.fail_fast || options.stopped_by_user();
    };
    golden.progress = [&](const std::string& name, std::size_t done, std::size_t total) {
        note_progress();
        progress.show(fmt::format("golden image {} of {}: {}", done + 1, total, name));
    };
    const auto device = Configuration{options.settings.parameters}.device(options.settings.threads);
    verify_golden(golden, backend_named(options.backend.name, device), report);
    progress.clear();
    if (!report.unjudged_units.empty() && report.stopped.empty() &&
        (options.settings.fail_fast || options.stopped_by_user())) {
        note_stop(options, report.unjudged_units.size(), report);
    }
    if (options.only_golden && units_of_golden(golden) == 0 && report.golden_failures.empty()) {
        throw reference::Error::bad_input(
            "--only-golden",
            "none of these scenes has a golden image; scotty golden check says "
            "which there are");
    }
    if (report.images.empty()) return;
    spdlog::info("golden images: {}, false alarms of all of them together: {:g}",
                 report.images.size(), report.false_alarm);
}

/// What the runs are held against, unless it was not asked for. The book has all that a
/// verification runs by default; of other scenes and pictures it has nothing to say.
std::optional<HashBook> hash_book(const VerifyOptions& options) {
    if (options.no_golden || options.only_golden || !options.settings.stage_pattern.empty())
        return {};
    std::optional<Hashes> hashes;
    try {
        hashes = golden_hashes(options.golden.empty() ? find_golden_folder()
                                                      : std::filesystem::path(options.golden));
    } catch (const reference::Error& error) {
        if (options.asks_golden()) throw;
        spdlog::warn("no golden hashes: {}", error.what());
    }
    const bool complete = options.asks_cases() && !options.thorough &&
                          verify::to_json(options.settings.parameters) ==
                              verify::to_json(default_verify_parameters());
    if (!hashes) return {};
    return std::optional<HashBook>(std::in_place, std::move(*hashes), complete);
}

SceneReport run_cases(VerifyOptions& options, const std::vector<Case>& cases) {
    VerifySettings settings = options.settings;
    settings.first_unit = 0;
    Progress progress;
    settings.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
        progress.show(fmt::format("case {} of {}: {}", done + 1, total, what));
    };
    settings.on_first_failure = [&](const PlacedFailure& first) {
        progress.clear();
        options.announce(first);
    };
    SceneReport report = verify_cases(cases, settings);
    progress.clear();
    spdlog::info("{} cases, {} rays, {:.1f} s: {}", report.configurations.size(), report.rays(),
                 report.seconds, report.passed() ? "passed" : "FAILED");
    return report;
}

/// A built-in scene is valid: what cannot be run with it is a failure.
SceneReport verify_one(const VerifyOptions& options, bool built_in, const reference::Scene& scene) {
    try {
        return verify_scene(scene, options.settings);
    } catch (const reference::Error& error) {
        if (!built_in || error.kind() == reference::ErrorKind::missing_environment) throw;
        SceneReport report = refused_scene(scene.name, error.what());
        report.warnings = scene.warnings;
        options.settings.on_first_failure(placed_failures(report).front());
        return report;
    }
}

int run_verify(VerifyOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    // Everything that can be wrong with the command line, before minutes of work.
    if (options.require_gpu) backend_named("cuda", options.settings.threads);
    chosen_backend(options.backend, options.settings.threads, options.settings.parameters);
    options.settings.backend = options.backend.name;
    options.settings.check = options.backend.check;
    options.settings.plant = options.backend.plant;
    reference::validate(options.settings.parameters);
    if (options.thorough) options.settings.filter.strength = 3;
    if (options.quick && !options.settings.filter.restricts()) options.settings.only.emplace();
    configurations(options.settings.parameters, options.settings.filter);
    const bool all_built_in = options.scenes.empty();
    options.all_scenes = all_built_in;
    catch_hangs(std::chrono::milliseconds(
        std::llround(1000.0 * options.patience.value_or(all_built_in ? kPatience : 0.0))));
    if (all_built_in) {
        for (const auto& scene : scenes::built_in_scenes()) options.scenes.push_back(scene.name);
    }
    // A run is known by its scene and number, in reports and between shards.
    for (auto scene = options.scenes.begin(); scene != options.scenes.end(); ++scene) {
        if (std::find(options.scenes.begin(), scene, *scene) == scene) continue;
        throw reference::Error::bad_input(*scene, "is named twice; once is enough");
    }
    std::vector<reference::Scene> loaded;
    std::vector<SceneReport> refused;  // of the built-in ones, which is nobody's mistake but ours
    for (const std::string& scene : options.scenes) {
        try {
            loaded.push_back(scenes::load_scene(scene));
        } catch (const reference::Error& error) {
            if (!all_built_in) throw;
            refused.push_back(refused_scene(scene, error.what()));
        }
    }
    if (all_built_in) {
        options.scenes.resize(
            loaded.size());  // small ones first: the first failure is found sooner
        std::stable_sort(loaded.begin(), loaded.end(), [](const auto& a, const auto& b) {
            return a.triangles.size() < b.triangles.size();
        });
        for (std::size_t i = 0; i < loaded.size(); ++i) options.scenes[i] = loaded[i].source;
    }

    // Runs are numbered over the whole sweep: cases, scene after scene, then the golden images.
    const Shard shard = parse_shard(options.shard);
    CaseList cases;
    if (options.asks_cases()) cases = covering_cases(options.budget());
    if (options.asks_golden() && options.golden.empty() &&
        units_of_golden(golden_settings(options, 0)) != 0) {
        options.golden = find_golden_folder().string();  // where there is none: before all the work
    }
    const std::size_t each = options.only_golden ? 0 : units_of_scene(options.settings);
    const std::size_t first_scene = cases.cases.size();
    const std::size_t first_golden = first_scene + each * loaded.size();
    const std::size_t units =
        first_golden +
        (options.asks_golden() ? units_of_golden(golden_settings(options, first_golden)) : 0);
    if (!options.shard.empty()) {
        options.settings.has_unit = [=](std::size_t unit) { return shard.has(unit, units); };
    }

    Report report;
    report.parameters = options.settings.parameters;
    report.threads = options.settings.threads != 0
                         ? options.settings.threads
                         : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    report.backend = options.settings.backend;
    report.command = options.command_line;
    std::optional<HashBook> book = hash_book(options);
    if (book) options.settings.hashes = &*book;
    const StopSignals signals;
    options.signals = &signals;
    options.settings.stop = [&] { return signals.received() != 0; };
    if (!cases.cases.empty()) {
        SceneReport found = run_cases(options, cases.cases);
        report.coverage = std::move(cases.coverage);
        if (found.left_out != 0 || (options.settings.fail_fast && !found.passed())) {
            note_stop(options, found.left_out, report);
        }
        if (!found.configurations.empty()) report.scenes.push_back(std::move(found));
    }
    for (SceneReport& scene : refused) {
        options.announce(placed_failures(scene).front());
        if (options.settings.fail_fast) note_stop(options, scene.left_out, report);
        report.scenes.push_back(std::move(scene));
    }
    for (std::size_t i = 0; i < loaded.size() && !options.only_golden && report.stopped.empty();
         ++i) {
        const auto warn = [&](const std::string& warning) {
            spdlog::warn("{}: {}", options.scenes[i], warning);
        };
        std::for_each(loaded[i].warnings.begin(), loaded[i].warnings.end(), warn);
        options.settings.first_unit = first_scene + i * each;
        Progress progress;
        options.settings.progress = [&](const std::string& what, std::size_t done,
                                        std::size_t total) {
            progress.show(fmt::format("scene {} of {}: {}, {} of {}: {}", i + 1, loaded.size(),
                                      loaded[i].name, done + 1, total, what));
        };
        options.settings.on_first_failure = [&](const PlacedFailure& first) {
            progress.clear();
            options.announce(first);
        };
        SceneReport scene = verify_one(options, all_built_in, loaded[i]);
        progress.clear();
        if (scene.left_out != 0 || (options.settings.fail_fast && !scene.passed())) {
            note_stop(options, scene.left_out, report);
        }
        if (scene.configurations.empty()) continue;  // all of it is other shards'
        const auto known = static_cast<std::ptrdiff_t>(loaded[i].warnings.size());
        std::for_each(scene.warnings.begin() + known, scene.warnings.end(), warn);
        spdlog::info("{}: {} configurations, {} rays, {:.1f} s: {}", scene.scene,
                     scene.configurations.size(), scene.rays(), scene.seconds,
                     scene.passed() ? "passed" : "FAILED");
        report.scenes.push_back(std::move(scene));
    }
    if (options.asks_golden() && report.stopped.empty()) {
        judge_golden_files(options, golden_settings(options, first_golden), report);
    } else if (options.backend.name == "simt" && !options.no_golden) {
        spdlog::info(
            "golden images are not asked of simt, which takes minutes: --only-golden does");
    }
    if (book) {
        if (report.coverage) report.coverage->hashes = book->size();
        spdlog::info("golden hashes: {} compared", book->compared());
    }
    report.seconds = seconds();
    report.checked = options.backend.check;
    if (report.checked) {
        for (const auto& read : emulation::simt::relaxed_meetings()) {
            report.relaxed_reads.push_back({read.line, read.met});
        }
    }
    if (!options.only_golden && !options.settings.has_unit && report.stopped.empty() &&
        report.judged_no_stage()) {
        throw reference::Error::bad_input(
            "--stage", fmt::format("no stage's name matches '{}'; names look like "
                                   "bounce1/light0/level3/intersect (* and ? may stand in)",
                                   options.settings.stage_pattern));
    }
    std::optional<ReportPart> part;
    if (!options.shard.empty()) part = {shard, units, sweep_of(options, loaded), report};
    write_reports(options, report, part);
    if (report.passed()) return kExitPassed;
    const bool nothing_failed = placed_failures(report).empty();
    return nothing_failed ? kExitStopped + signals.received() : kExitFailed;
}

}  // namespace

void add_verify_command(CLI::App& app, Action& action, const std::string& command_line) {
    auto* command = app.add_subcommand(
        "verify",
        "Check every launch, every hit and the image, in many configurations of the pipeline.");
    command->footer(
        "Examples:\n"
        "  scotty verify                                all pairs of values: on small scenes of "
        "all\n"
        "                                               parameters, on the built-in scenes\n"
        "  scotty verify --quick                        what catches most, in seconds\n"
        "  scotty verify coil --width 8,16 --early-out level\n"
        "                                               all combinations of these, pairs of the "
        "rest\n"
        "  scotty verify spheres --all                  every combination\n"
        "  scotty verify spheres --width 8 --rays-per-block 64 --queue-levels 0 --early-out off "
        "\\\n"
        "      --hit-mode buffer --block-order linear --shadow-query any --hit-capacity 8 "
        "--batch-rays 262144 \\\n"
        "      --schedule linear --stage 'bounce0/level2/*'\n"
        "                                               one configuration, some of its stages\n"
        "  scotty verify --backend cuda                 the CUDA pipeline, against the emulator "
        "too\n"
        "  scotty verify --json - | jq .passed\n"
        "  scotty verify --shard 2/8 --json 2.json      one of eight parts, for scotty report\n\n"
        "Checked are invariants after every launch; the hits of every traversal against brute\n"
        "force (bit for bit) and Embree (differences adjudicated); every configuration against "
        "the\n"
        "baseline (bit for bit); the image against the same paths through Embree; image and stage\n"
        "ledger of the built-in scenes against golden ones (docs/golden.md).");
    auto options = std::make_shared<VerifyOptions>();
    options->command_line = command_line;
    options->settings.parameters = default_verify_parameters();
    command->add_option("scenes", options->scenes,
                        "built-in scenes (scotty list) or files; all built-in ones by default");
    add_backend_options(*command, options->backend,
                        "emulator, simt or cuda: whose runs are verified; all but the emulator's "
                        "are compared with it, launch by launch, too",
                        false);
    command->add_flag("--require-gpu", options->require_gpu,
                      "fail (exit code 3) where there is no CUDA device");
    add_report_outputs(*command, options->outputs);
    command
        ->add_option("--report", options->folder,
                     "write all three (verify.json, verify.junit.xml, verify.html) to a folder")
        ->type_name("DIR")
        ->check(output_folder());
    command
        ->add_option("--stage", options->settings.stage_pattern,
                     "judge only stages of such a name: a part of it, or with * and ? all of it")
        ->type_name("PATTERN");
    command->add_flag("--fail-fast", options->settings.fail_fast,
                      "end at the first failure, which is printed as soon as it is found in any "
                      "case");
    command
        ->add_option("--patience", options->patience,
                     "seconds without the end of a launch, a run or an image, after which the "
                     "verification has failed as one that hangs; 0: never (300, and 0 where "
                     "scenes are named)")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.0, 1e6));
    command->add_flag("!--no-oracles", options->settings.oracles,
                      "leave out brute force and Embree");
    command
        ->add_option("--brute-force", options->settings.brute_force_tests,
                     "ray-triangle tests a scene for brute force; a subset of the rays beyond it")
        ->type_name("TESTS")
        ->capture_default_str();
    auto* no_golden =
        command->add_flag("--no-golden", options->no_golden,
                          "leave out golden images, ledgers and hashes (they are left out, "
                          "too, where configurations or stages are selected)");
    command
        ->add_flag("--only-golden", options->only_golden,
                   "nothing but golden images and ledgers (docs/golden.md)")
        ->excludes(no_golden);
    command->add_option("--golden", options->golden, "the folder of golden files")
        ->type_name("DIR");
    command
        ->add_option("--schedules", options->settings.schedules,
                     "run every configuration also under the first N of linear, reversed, strided, "
                     "adversarial, shuffle:1, shuffle:2, ...: determined results must not differ")
        ->type_name("N")
        ->check(CLI::Range(1, 1000000));
    command
        ->add_option_function<std::string>(
            "--filter",
            [options](const std::string& word) {
                options->settings.parameters.filter = reference::parse_filter(word);
            },
            "smooth the image at the end, and check that [none]")
        ->type_name("none|gaussian|bilateral|median");
    command
        ->add_option("--filter-threshold", options->settings.parameters.filter_threshold,
                     "filter only below so many samples a pixel")
        ->capture_default_str();
    auto* quick = command->add_flag(
        "--quick", options->quick,
        "the cases that hold most pairs of values, of each scene the baseline, no golden images");
    command
        ->add_flag("--thorough", options->thorough,
                   "all triples of values where all pairs are run otherwise; minutes")
        ->excludes(quick);
    add_shard_option(*command, options->shard);
    add_thread_option(*command, options->settings.threads);
    add_picture_options(*command, options->settings.parameters);
    add_filter_options(*command, options->settings.filter);
    command->callback([&action, options] { action = [options] { return run_verify(*options); }; });
}

}  // namespace scotty::verify
