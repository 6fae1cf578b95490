/// scotty bench: how fast, and how sharp the image gates are.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "verify/backends/backend.h"
#include "verify/backends/machine.h"
#include "verify/backends/simt/simt_pipeline.h"
#include "verify/base/ask.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/bench/bench.h"
#include "verify/bench/bench_check.h"
#include "verify/bench/bench_gates.h"
#include "verify/bench/bench_simt.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/report/report.h"
#include "verify/sweep/configurations.h"

namespace scotty::verify {
namespace {

struct BenchOptions {
    std::string what;
    std::string scene = "coil";
    JsonOutput json;
    BenchSettings settings;
    GateBenchSettings gates;
};

/// With the machine, which is described before the measurement: its load is not ours.
template <class Report>
int print_report(const BenchOptions& options, const MachineDescription& machine, Progress& progress,
                 const Report& report) {
    progress.clear();
    nlohmann::json json = to_json(report);
    json["machine"] = to_json(machine);
    print_result(options.json, json.dump(2),
                 table(report) + "\nmachine: " + one_line(machine) + "\n");
    return kExitPassed;
}

/// What the picture options say; a size and samples of its own where they say nothing.
GateBenchSettings gate_settings(const BenchOptions& options, const CLI::App& command) {
    GateBenchSettings gates = options.gates;
    const reference::PipelineParameters& p = options.settings.parameters;
    if (command.count("--size") != 0) {
        gates.image.width = p.image_width;
        gates.image.height = p.image_height;
    }
    if (command.count("--spp") != 0) gates.image.samples = p.spp;
    if (command.count("--seed") != 0) gates.image.seed = p.seed;
    if (gates.image.samples < 2) {
        throw reference::Error::bad_input(
            "--spp", "expected 2 or more: one sample has no variance, found 1");
    }
    return gates;
}

/// The same picture, one round, by the program that checks.
std::string checked_half(const BenchOptions& options) {
    const reference::PipelineParameters& p = options.settings.parameters;
    const auto self = std::filesystem::read_symlink("/proc/self/exe");
    return fmt::format("{} bench check {} --repeats 1 --warm-ups 1 --threads {} {} {}",
                       shell_word((self.parent_path() / "scotty-checked").string()),
                       shell_word(options.scene), options.settings.threads, picture_options(p),
                       pipeline_options(p));
}

int run_bench_check(const BenchOptions& options, const MachineDescription& machine,
                    const reference::Scene& scene, Progress& progress) {
    if (simt::checks_memory()) {
        print_result(render_seconds(scene, options.settings).dump());
        return kExitPassed;
    }
    const CheckBenchReport report = bench_check(scene, options.settings, checked_half(options));
    print_report(options, machine, progress, report);
    return report.passed() ? kExitPassed : kExitFailed;
}

int run_bench(BenchOptions& options, const CLI::App& command) {
    reference::validate(options.settings.parameters);
    const MachineDescription machine = machine_description();
    if (options.what == "gates") {
        GateBenchSettings gates = gate_settings(options, command);
        const std::size_t threads = options.settings.threads;
        const tbb::global_control limit(
            tbb::global_control::max_allowed_parallelism,
            threads != 0 ? threads : static_cast<std::size_t>(tbb::info::default_concurrency()));
        Progress progress;
        gates.progress = [&](const std::string& what) { progress.show(what); };
        return print_report(options, machine, progress, bench_gates(gates));
    }
    if (!options.settings.peers.empty() && options.what != "emulator" && options.what != "cuda" &&
        options.what != "embree") {
        throw reference::Error::bad_input(
            "--peers", fmt::format("only with emulator, cuda and embree, which trace rays by kind; "
                                   "{} does not",
                                   options.what));
    }
    if (!options.settings.peers.empty()) peer_names(options.settings.peers);
    if (options.what == "check" && command.count("--size") == 0) {
        // The checked tiers take their time.
        options.settings.parameters.image_width = 128;
        options.settings.parameters.image_height = 128;
    }
    if (options.what == "cuda") {
        backend_named("cuda", options.settings.threads);  // or says what is missing
        // A device wants more rays in flight than fit a processor's cache.
        if (command.count("--batch-rays") == 0) options.settings.parameters.batch_rays = 1u << 20;
    }
    const reference::Scene scene = scenes::load_scene(options.scene);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
    Progress progress;
    options.settings.progress = [&](const std::string& what) { progress.show(what); };
    if (options.what == "check") return run_bench_check(options, machine, scene, progress);
    if (options.what == "simt") {
        return print_report(options, machine, progress, bench_simt(scene, options.settings));
    }
    if (options.what == "embree") {
        return print_report(options, machine, progress, bench_embree(scene, options.settings));
    }
    return print_report(options, machine, progress,
                        bench_backend(scene, options.settings, options.what));
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("bench",
                                       "Measure rays per second by ray kind, time by stage, level "
                                       "and kernel, and count what blocks "
                                       "and queues did; or the power of the image gates.");
    command->footer(
        "Examples:\n"
        "  scotty bench emulator                        the coil at 512x512\n"
        "  scotty bench emulator blob --width 16 --threads 1\n"
        "  scotty bench emulator --json - | jq .ratio_to_embree\n"
        "  scotty bench cuda coil --queue-levels 2      on the device, timed by its events\n"
        "  scotty bench embree coil --repeats 9         Embree alone\n"
        "  scotty bench cuda coil --peers peers/        and every tracer of that folder\n"
        "  scotty bench simt                            the CUDA text on the CPU, beside the "
        "emulator\n"
        "  scotty bench check                           what --check costs on both; 1 is over a "
        "limit\n"
        "  scotty bench gates --trials 50 --spp 64      which faults the image gates reject, how "
        "often\n\n"
        "The rays of every traversal of one render are collected first and then traced by both, "
        "in\n"
        "turn: the same rays, threads and machine. Embree traces single rays. Figures are medians; "
        "IQR is\n"
        "the range between the quartiles. What each column means: docs/benchmarks.md.");
    auto options = std::make_shared<BenchOptions>();
    options->settings.parameters.image_width = 512;
    options->settings.parameters.image_height = 512;
    options->settings.parameters.spp = 1;
    command
        ->add_option("what", options->what,
                     "what to measure: emulator, simt, embree, cuda, check or gates")
        ->required()
        ->check(CLI::IsMember({"emulator", "simt", "embree", "cuda", "check", "gates"}));
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->capture_default_str();
    add_json_option(*command, options->json);
    command->add_option("--repeats", options->settings.repeats, "measurements; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--warm-ups", options->settings.warm_ups, "rounds before those")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    command->add_option("--trials", options->gates.trials, "gates: images for each fault")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command
        ->add_option("--false-alarm", options->gates.false_alarm,
                     "gates: probability that a sound image is rejected")
        ->check(CLI::Range(1e-15, 0.5))
        ->capture_default_str();
    command
        ->add_option("--peers", options->settings.peers,
                     "emulator, cuda and embree: a folder of other tracers' programs, which trace "
                     "the same rays (docs/benchmarks.md)")
        ->type_name("FOLDER")
        ->check(CLI::ExistingDirectory);
    add_thread_option(*command, options->settings.threads);
    add_picture_options(*command, options->settings.parameters);
    add_pipeline_options(*command, options->settings.parameters);
    add_pass_option(*command, options->settings.parameters);
    command->callback([&action, options, command] {
        action = [options, command] { return run_bench(*options, *command); };
    });
}

}  // namespace scotty::verify
