#include "verify/emulator_diff.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <system_error>
#include <utility>

#include "verify/backend.h"
#include "verify/capture_writer.h"

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

fs::path temporary_folder() {
    static std::atomic<int> made{0};
    return fs::temp_directory_path() / fmt::format("scotty-{}-{}", getpid(), made++);
}

DiffOptions options_for(const std::string& backend) {
    DiffOptions options;
    options.b_backend = backend;
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
    failure.ray = first.ray;
    failure.field = first.field.empty() ? first.buffer : first.buffer + "." + first.field;
    failure.expected = first.a;
    failure.found = first.b;
    failure.sentence = fmt::format("{} (A: emulator, B: {})", first.sentence, backend);
    return failure;
}

}  // namespace

EmulatorDiff::EmulatorDiff(const PipelineInput& input, std::size_t threads,
                           const std::string& backend)
    : folder_(temporary_folder()) {
    {
        CaptureWriter writer(folder_,
                             header_of("emulator", input.scene, input.bvh, input.parameters));
        write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
        backend_named("emulator", threads).render(input, &writer);
        writer.finish();
    }
    capture_.emplace(Capture::open(folder_));
    differ_.emplace(*capture_, options_for(backend));
}

EmulatorDiff::~EmulatorDiff() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

std::vector<Failure> EmulatorDiff::finish(StageCounts& counts, bool whole_run) {
    const DiffReport report = differ_->finish([=](std::string_view) { return whole_run; });
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
