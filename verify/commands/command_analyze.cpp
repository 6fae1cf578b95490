/// scotty analyze: the report's analyses, measured and drawn.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "verify/analysis/analysis_catalog.h"
#include "verify/analysis/analysis_figures.h"
#include "verify/analysis/analysis_measure.h"
#include "verify/analysis/analysis_page.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/base/stop_signal.h"
#include "verify/capture/capture_format.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;

struct AnalyzeOptions {
    std::string scene = "coil";
    AnalysisSettings settings;
    std::vector<std::string> from;
    std::string directory = "analysis";
    JsonOutput json;
};

void write_json(const AnalyzeOptions& options, const std::vector<AnalysisRun>& runs) {
    reference::write_file(fs::path(options.directory) / "analysis.json",
                          to_json(runs).dump(1) + "\n");
}

/// Everything that was found, and what it is seen in.
void write_all(const AnalyzeOptions& options, const std::vector<AnalysisRun>& runs) {
    const fs::path directory = options.directory;
    write_json(options, runs);
    for (const AnalysisDefinition& definition : analysis_catalog()) {
        const bool there = std::any_of(runs.begin(), runs.end(), [&](const AnalysisRun& run) {
            return run.find(definition.name) != nullptr;
        });
        if (!there) continue;
        reference::write_file(directory / (definition.name + ".svg"), figure(definition, runs));
    }
    reference::write_file(directory / "analysis.html", analysis_page(runs));
    spdlog::info("wrote {}", (directory / "analysis.html").string());
}

void print(const AnalyzeOptions& options, const std::vector<AnalysisRun>& runs) {
    print_result(options.json, to_json(runs).dump(1), analysis_text(runs));
}

int draw_files(const AnalyzeOptions& options) {
    std::vector<AnalysisRun> runs;
    for (const std::string& file : options.from) {
        for (AnalysisRun& run : parse_analysis(file, read_json(file))) {
            runs.push_back(std::move(run));
        }
    }
    write_all(options, runs);
    print(options, runs);
    return kExitPassed;
}

int measure(AnalyzeOptions& options, const CLI::App& command) {
    AnalysisSettings& settings = options.settings;
    for (const std::string& name : settings.names) analysis_named("--analysis", name);
    settings.keep_size = command.count("--size") != 0 || command.count("--spp") != 0;
    const Backend backend = backend_named(settings.render.backend, settings.render.threads);
    expect_arithmetic(backend, settings.render.parameters);
    if (settings.render.parameters.queues == reference::QueueKind::pairs) {
        throw reference::Error::bad_input(
            "--queues", "the 2018 paper's analyses are of queues of nodes, not of pairs");
    }
    const reference::Scene scene = load_scene_argument(options.scene);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
    const StopSignals signals;
    Progress progress;
    settings.render.progress = [&](const std::string& what) { progress.show(what); };
    settings.stop = [&] { return signals.received() != 0; };
    settings.finished = [&](const AnalysisRun& run) { write_json(options, {run}); };
    const std::vector<AnalysisRun> runs{analyze(scene, settings)};
    progress.clear();
    const int signal = signals.received();
    if (signal != 0) spdlog::warn("stopped; {} analyses were finished", runs[0].results.size());
    if (!runs[0].results.empty()) {
        write_all(options, runs);
        print(options, runs);
    }
    return signal != 0 ? kExitStopped + signal : kExitPassed;
}

constexpr const char* kAnalyzeFooter = R"(Examples:
  scotty analyze                               all of them on the emulator, into analysis/
  scotty analyze --backend cuda -o h100        on the device
  scotty analyze --analysis width --analysis levels --repeats 9
  scotty analyze dragon.dae --size 128x128 --json | jq '.runs[0].analyses[].name'
  scotty analyze --from h100/analysis.json --from analysis/analysis.json -o both
                                               two machines in one page, drawn on any

Without --size and --spp the pictures are the report's: 256x256 with 4 samples, 1024x1024 with 1 for
levels, 256x256 with 16 for bounces. A file with what is finished is kept where a run is stopped.)";

void add_choices(CLI::App& command, AnalyzeOptions& options) {
    AnalysisSettings& settings = options.settings;
    command.add_option("scene", options.scene, "a built-in scene (scotty list) or a file")
        ->capture_default_str();
    command.add_option("--analysis", settings.names, "only this one; may be given again")
        ->type_name("NAME")
        ->allow_extra_args(false);
    command
        .add_option("--from", options.from,
                    "measure nothing, draw this analysis.json; may be given again")
        ->type_name("FILE")
        ->allow_extra_args(false);
    command
        .add_option("-o,--output", options.directory, "folder for analysis.json, .html and .svg")
        ->type_name("DIR")
        ->check(output_folder())
        ->capture_default_str();
    add_json_option(command, options.json);
    command.add_flag("--quick", settings.quick, "small pictures: shows that it works, no more");
}

}  // namespace

void add_analyze_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "analyze", "Repeat the report's analyses and draw them, beside the report's figures.");
    command->footer(kAnalyzeFooter);
    auto options = std::make_shared<AnalyzeOptions>();
    add_choices(*command, *options);
    RenderSettings& render = options->settings.render;
    render.repeats = 5;
    command->add_option("--backend", render.backend, "emulator, simt or cuda")
        ->capture_default_str();
    command->add_option("--repeats", render.repeats, "measurements; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--warm-ups", render.warm_ups, "rounds before those")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    add_thread_option(*command, render.threads);
    add_picture_options(*command, render.parameters);
    add_pipeline_options(*command, render.parameters);
    command->remove_option(command->get_option("--batch-rays"));  // all rays are in one traversal
    add_arithmetic_option(*command, render.parameters);
    command->callback([&action, options, command] {
        action = [options, command] {
            return options->from.empty() ? measure(*options, *command) : draw_files(*options);
        };
    });
}

}  // namespace scotty::verify
