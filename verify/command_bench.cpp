/// scotty bench: how fast.
#include <spdlog/spdlog.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "reference/error.h"
#include "scenes/scenes.h"
#include "verify/bench.h"
#include "verify/bench_simt.h"
#include "verify/command.h"
#include "verify/options.h"
#include "verify/progress.h"
#include "verify/report.h"

namespace scotty::verify {
namespace {

struct BenchOptions {
    std::string what;
    std::string scene = "coil";
    std::string json;
    BenchSettings settings;
};

template <class Report>
int print_report(const BenchOptions& options, Progress& progress, const Report& report) {
    progress.clear();
    const std::string json = to_json(report).dump(2);
    if (!options.json.empty() && options.json != "-") write_file(options.json, json + "\n");
    print_result(options.json == "-" ? json : table(report));
    return kExitPassed;
}

int run_bench(BenchOptions& options) {
    reference::validate(options.settings.parameters);
    const reference::Scene scene = scenes::load_scene(options.scene);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
    Progress progress;
    options.settings.progress = [&](const std::string& what) { progress.show(what); };
    if (options.what == "simt") {
        return print_report(options, progress, bench_simt(scene, options.settings));
    }
    return print_report(options, progress, bench_emulator(scene, options.settings));
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "bench", "Measure rays per second by ray kind, and time by stage and level.");
    command->footer(
        "Examples:\n"
        "  scotty bench emulator                        the coil at 512x512\n"
        "  scotty bench emulator blob --width 16 --threads 1\n"
        "  scotty bench emulator --json - | jq .ratio_to_embree\n"
        "  scotty bench simt                            the CUDA text on the CPU, beside the "
        "emulator\n\n"
        "The rays of every traversal of one render are collected first and then traced by both, "
        "in\n"
        "turn: the same rays, threads and machine. Embree traces single rays.");
    auto options = std::make_shared<BenchOptions>();
    options->settings.parameters.image_width = 512;
    options->settings.parameters.image_height = 512;
    options->settings.parameters.spp = 1;
    command->add_option("what", options->what, "what to measure: emulator or simt")
        ->required()
        ->check(CLI::IsMember({"emulator", "simt"}));
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->capture_default_str();
    command->add_option("--json", options->json, "write the figures as JSON; - is standard output")
        ->type_name("FILE")
        ->expected(0, 1)
        ->default_str("-");
    command->add_option("--repeats", options->settings.repeats, "measurements; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--warm-ups", options->settings.warm_ups, "rounds before those")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    add_thread_option(*command, options->settings.threads);
    add_picture_options(*command, options->settings.parameters);
    add_pipeline_options(*command, options->settings.parameters);
    command->callback([&action, options] { action = [options] { return run_bench(*options); }; });
}

}  // namespace scotty::verify
