#include "verify/schedules/interleave.h"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/backends/simt/simt_interleave.h"
#include "verify/capture/canonical.h"
#include "verify/capture/pipeline_input.h"
#include "verify/capture/replay_inputs.h"

namespace scotty::verify {

using emulation::simt::Interleaving;
using emulation::simt::Switch;

namespace {

/// Calls back with the stage, prepared to run alone.
template <class Use>
void with_stage(const Capture& capture, const std::string& stage, const Use& use) {
    const StageRecord* record = capture.find(stage);
    if (record == nullptr) {
        throw reference::Error::bad_input(capture.directory().string(),
                                          fmt::format("holds no stage '{}'", stage));
    }
    const PipelineInput input = read_pipeline_input(capture.directory());
    const LoadedStage prepared = prepare_stage(capture, *record);
    const auto canonical = [&](const std::vector<reference::OwnedBuffer>& outputs) {
        return canonical_outcome(prepared.view, outputs, input.parameters);
    };
    use(simt::InterleavedStage{input.scene, input.bvh, input.parameters, prepared.view, canonical},
        *record);
}

std::string error_in(const std::string& outcome) {
    return outcome.starts_with("error: ") ? outcome.substr(7) : std::string();
}

std::string switches_text(const Interleaving& interleaving) {
    std::string out;
    for (const Switch& change : interleaving.switches) {
        out += fmt::format("  {}\n", emulation::simt::to_text(change));
    }
    return out.empty() ? "  one block after the other\n" : out;
}

nlohmann::json switches_json(const Interleaving& interleaving) {
    nlohmann::json out = nlohmann::json::array();
    for (const Switch& change : interleaving.switches) {
        out.push_back({{"block", change.block}, {"access", change.access}, {"to", change.to}});
    }
    return out;
}

}  // namespace

InterleaveReport interleave_stage(const Capture& capture, const std::string& stage,
                                  const emulation::simt::ExploreOptions& options,
                                  const std::filesystem::path& save) {
    InterleaveReport report;
    report.stage = stage;
    report.options = options;
    with_stage(capture, stage, [&](const simt::InterleavedStage& run, const StageRecord& record) {
        report.blocks = record.blocks;
        report.exploration = simt::explore_simt_stage(run, options);
    });
    if (report.exploration.failing) {
        write_interleaving(save, *report.exploration.failing);
        report.saved = save.string();
        report.replay = fmt::format("scotty replay '{}' --stage {} --backend simt --schedule '{}'",
                                    capture.directory().string(), stage, report.saved);
    }
    return report;
}

InterleavedReplay replay_interleaved(const Capture& capture, const std::string& stage,
                                     const std::filesystem::path& file) {
    InterleavedReplay out;
    out.stage = stage;
    out.interleaving = emulation::simt::read_interleaving(file);
    with_stage(capture, stage, [&](const simt::InterleavedStage& run, const StageRecord&) {
        Interleaving linear = out.interleaving;
        linear.switches.clear();
        const std::string found = simt::replay_simt_stage(run, out.interleaving);
        out.error = error_in(found);
        out.same = simt::replay_simt_stage(run, linear) == found;
    });
    return out;
}

std::string to_text(const InterleaveReport& report) {
    const auto& e = report.exploration;
    const std::string which =
        report.options.preemptions
            ? fmt::format("all orders with at most {} preemptions", *report.options.preemptions)
            : "all orders";
    std::string out =
        fmt::format("{}: {} blocks meet in {} words of memory; {} schedules run ({}): {}\n",
                    report.stage, report.blocks, e.words, e.schedules, which,
                    e.failing    ? "FAILED"
                    : e.complete ? "one outcome"
                                 : "GIVEN UP before all were run (--most, --preemptions)");
    if (!e.failing) return out;
    out += "another outcome than one block after the other, where\n" + switches_text(*e.failing);
    const std::string error = error_in(e.found);
    if (!error.empty()) out += fmt::format("  {}\n", error);
    return out + fmt::format("saved: {}\nshow it again: {}\n", report.saved, report.replay);
}

nlohmann::json to_json(const InterleaveReport& report) {
    const auto& e = report.exploration;
    nlohmann::json out{{"passed", report.passed()},
                       {"stage", report.stage},
                       {"blocks", report.blocks},
                       {"words", e.words},
                       {"schedules", e.schedules},
                       {"complete", e.complete},
                       {"most", report.options.most_schedules}};
    if (report.options.preemptions) out["preemptions"] = *report.options.preemptions;
    if (!e.failing) return out;
    out["switches"] = switches_json(*e.failing);
    out["error"] = error_in(e.found);
    out["saved"] = report.saved;
    out["replay"] = report.replay;
    return out;
}

std::string to_text(const InterleavedReplay& replay) {
    std::string out =
        fmt::format("{}, where\n{}", replay.stage, switches_text(replay.interleaving));
    if (!replay.error.empty()) out += fmt::format("  {}\n", replay.error);
    return out + (replay.same ? "the outcome of one block after the other\n"
                              : "FAILED: another outcome than one block after the other\n");
}

nlohmann::json to_json(const InterleavedReplay& replay) {
    return {{"passed", replay.same},
            {"stage", replay.stage},
            {"switches", switches_json(replay.interleaving)},
            {"error", replay.error}};
}

}  // namespace scotty::verify
