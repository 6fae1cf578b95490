#include "verify/sweep/emulator_diff.h"

#include <fmt/format.h>

#include <utility>

namespace scotty::verify {

namespace {

DiffOptions options_for(const Backend& backend) {
    DiffOptions options;
    options.b_backend = backend.name;
    options.written_by = backend.written_by;
    return options;
}

Failure to_failure(const StageResult& stage, const std::string& backend) {
    Failure failure;
    failure.invariant = "same-as-emulator";
    failure.stage = stage.name;
    failure.launch = stage.launch;
    if (!stage.first) {
        failure.sentence = fmt::format("{} shows values that are not finite", backend);
        return failure;
    }
    const Divergence& first = *stage.first;
    failure.level = first.level;
    failure.node = first.node;
    failure.block = first.block;
    failure.thread = first.thread;
    failure.ray = first.ray;
    failure.field = first.field.empty() ? first.buffer : first.buffer + "." + first.field;
    failure.expected = first.a;
    failure.found = first.b;
    failure.written_by = first.written_by;
    failure.sentence = fmt::format("{} (A: emulator, B: {})", first.sentence, backend);
    return failure;
}

}  // namespace

EmulatorDiff::EmulatorDiff(const PipelineInput& input, std::size_t threads, const Backend& backend)
    : expected_(backend_named("emulator", threads), input),
      differ_(expected_.get(), options_for(backend)) {}

std::vector<Failure> EmulatorDiff::finish(StageCounts& counts, bool whole_run) {
    const DiffReport report = differ_.finish([=](std::string_view) { return whole_run; });
    std::vector<Failure> failures;
    for (const StageResult& stage : report.stages) {
        if (stage.failed()) {
            ++counts.differ;
            failures.push_back(to_failure(stage, report.b_backend));
        } else if (stage.verdict == Verdict::identical) {
            ++counts.identical;
        } else if (stage.verdict == Verdict::reordered) {
            ++counts.reordered;
        } else {
            ++counts.within_bounds;
        }
    }
    return failures;
}

}  // namespace scotty::verify
