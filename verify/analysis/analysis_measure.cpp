#include "verify/analysis/analysis_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "verify/analysis/analysis_catalog.h"
#include "verify/analysis/analysis_parts.h"
#include "verify/analysis/analysis_renders.h"
#include "verify/backends/machine.h"

namespace scotty::verify {

namespace {

const std::map<std::string, Analyzer*>& analyzers() {
    static const std::map<std::string, Analyzer*> all{{"rays", analyze_rays},
                                                      {"width", analyze_width},
                                                      {"rays-per-block", analyze_rays_per_block},
                                                      {"bounces", analyze_bounces},
                                                      {"levels", analyze_levels},
                                                      {"stages", analyze_stages},
                                                      {"early-out", analyze_early_out},
                                                      {"strided", analyze_strided},
                                                      {"limited-blocks", analyze_limited_blocks},
                                                      {"memory", analyze_memory}};
    return all;
}

/// The label is short, because it stands beside every line of this run.
std::string label_of(const AnalysisSettings& settings, const MachineDescription& machine) {
    if (settings.render.backend == "cuda" && machine.cuda) {
        const std::string& device = machine.cuda->device;  // "NVIDIA H100 80GB HBM3"
        const std::size_t begin = device.starts_with("NVIDIA ") ? 7 : 0;
        return device.substr(begin, device.find(' ', begin) - begin);
    }
    const std::size_t threads =
        settings.render.threads != 0 ? settings.render.threads : machine.usable_threads;
    return fmt::format("{}, {} thread{}", settings.render.backend, threads,
                       threads == 1 ? "" : "s");
}

}  // namespace

AnalysisRun analyze(const reference::Scene& scene, const AnalysisSettings& settings) {
    for (const std::string& name : settings.names) analysis_named("--analysis", name);
    std::vector<std::string> names;  // in the catalog's order, each once
    for (const AnalysisDefinition& one : analysis_catalog()) {
        const auto& wanted = settings.names;
        if (wanted.empty() || std::find(wanted.begin(), wanted.end(), one.name) != wanted.end()) {
            names.push_back(one.name);
        }
    }
    const MachineDescription machine = machine_description();
    AnalysisRun run;
    run.label = label_of(settings, machine);
    run.backend = settings.render.backend;
    run.scene = scene.name;
    run.triangles = scene.triangles.size();
    run.machine = one_line(machine);
    run.machine_details = to_json(machine);
    run.repeats = settings.render.repeats;
    std::string doing;
    RenderSettings render = settings.render;
    if (render.progress) {
        render.progress = [&](const std::string& what) {
            settings.render.progress(doing + ": " + what);
        };
    }
    AnalysisRenders renders(scene, std::move(render), settings.stop);
    try {
        for (std::size_t i = 0; i < names.size(); ++i) {
            doing = fmt::format("{} of {}, {}", i + 1, names.size(), names[i]);
            run.results.push_back(analyzers().at(names[i])(settings, renders));
            if (settings.finished) settings.finished(run);
        }
    } catch (const AnalysisRenders::Stopped&) {
        // Complete analyses are kept.
    }
    return run;
}

}  // namespace scotty::verify
