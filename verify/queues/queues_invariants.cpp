#include "verify/queues/queues_invariants.h"

#include <fmt/format.h>

#include "verify/base/progress.h"
#include "verify/capture/pipeline_input.h"
#include "verify/invariants/invariants.h"

namespace scotty::verify {

CheckedRun check_capture(const Capture& capture) {
    CheckedRun run;
    if (!capture.header().patterns.empty() || !capture.has_buffers()) return run;
    run.asked = true;
    const PipelineInput input = read_pipeline_input(capture.directory());
    InvariantSettings settings;
    settings.max_failures = 1000;
    InvariantChecker checker(input.scene, input.bvh, capture.header().parameters, settings);
    Progress progress;
    for (const StageRecord& stage : capture.stages()) {
        progress.show(fmt::format("checking {}", stage.name));
        checker.on_stage(capture.load(stage).view);
    }
    for (const Failure& failure : checker.failures()) {
        run.failures[failure.launch].push_back(failure);
    }
    run.not_kept = checker.counts().failures - checker.failures().size();
    return run;
}

}  // namespace scotty::verify
