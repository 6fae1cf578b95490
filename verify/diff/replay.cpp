#include "verify/diff/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/failure.h"
#include "verify/capture/replay_inputs.h"

namespace scotty::verify {

using reference::Error;
using reference::OwnedBuffer;
using reference::StageView;

namespace {

/// Runs a stage on captured inputs and shows the outputs to the differ.
void run_alone(const Capture& capture, const StageRecord& record, const PipelineInput& input,
               const Backend& backend, Differ& differ) {
    const LoadedStage prepared = prepare_stage(capture, record);
    LoadedStage ran;
    ran.view = bare_view(record);
    ran.view.inputs = prepared.view.inputs;  // the same memory
    for (OwnedBuffer& buffer : backend.pipeline(input)->run_stage(prepared.view)) {
        ran.add_output(std::move(buffer));
    }
    differ.on_stage(ran.view);
}

DiffOptions isolated_options(DiffOptions options, const Backend& backend) {
    options.isolated = true;
    options.b_backend = backend.name;
    return options;
}

std::string nearest_names(const Capture& capture, const std::string& wanted) {
    std::string names;
    std::size_t shown = 0;
    for (const StageRecord& stage : capture.stages()) {
        if (!stage_matches(wanted, stage.name) && shown >= 5) continue;
        if (++shown > 8) return names + ", ...";
        names += (names.empty() ? "" : ", ") + stage.name;
    }
    return names.empty() ? "none" : names;
}

}  // namespace

DiffReport replay_stage(const Capture& capture, const std::string& stage, const Backend& backend) {
    const StageRecord* record = capture.find(stage);
    if (record == nullptr) {
        throw Error::bad_input(capture.directory().string(),
                               fmt::format("holds no stage '{}'; it has {} stages: {}", stage,
                                           capture.stages().size(), nearest_names(capture, stage)));
    }
    expect_own(capture);
    const PipelineInput input = read_pipeline_input(capture.directory());
    Differ differ(capture, isolated_options({}, backend));
    run_alone(capture, *record, input, backend, differ);
    DiffReport report = differ.finish([&](std::string_view name) { return name == record->name; });
    report.not_compared = 0;  // one stage was asked for
    report.b = fmt::format("{} of A, run by the {}", stage, backend.name);
    return report;
}

DiffReport diff_isolated(const Capture& capture, const Backend& backend, DiffOptions options) {
    expect_own(capture);
    PipelineInput input = read_pipeline_input(capture.directory());
    input.parameters.arithmetic = options.b_arithmetic;
    const std::vector<std::string> patterns = options.patterns;
    Differ differ(capture, isolated_options(std::move(options), backend));
    for (const StageRecord& stage : capture.stages()) {
        const bool asked = patterns.empty() ||
                           std::any_of(patterns.begin(), patterns.end(),
                                       [&](const auto& p) { return stage_matches(p, stage.name); });
        if (!asked) continue;
        try {
            run_alone(capture, stage, input, backend, differ);
        } catch (const Error& error) {
            if (error.kind() != reference::ErrorKind::bad_input) throw;
            differ.add_error(stage, error.what());
        }
    }
    DiffReport report = differ.finish([](std::string_view) { return true; });
    report.b = fmt::format("the {}", backend.name);
    return report;
}

DiffReport diff_with_run(const Capture& capture, const Backend& backend, DiffOptions options) {
    expect_own(capture);
    PipelineInput input = read_pipeline_input(capture.directory());
    input.parameters.arithmetic = options.b_arithmetic;
    options.b_backend = backend.name;
    options.written_by = backend.written_by;
    Differ differ(capture, std::move(options));
    bool whole_run = true;
    try {
        backend.render(input, &differ);
    } catch (const reference::Error& error) {
        // Earlier findings lead, because they may well be the reason.
        if (error.kind() != reference::ErrorKind::internal) throw;
        differ.add_end(error.what());
        whole_run = false;
    }
    DiffReport report = differ.finish([&](std::string_view) { return whole_run; });
    report.b = fmt::format("a run of the {}", backend.name);
    return report;
}

}  // namespace scotty::verify
