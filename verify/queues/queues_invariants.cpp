#include "verify/queues/queues_invariants.h"

#include <fmt/format.h>

#include "verify/base/progress.h"
#include "verify/capture/pipeline_input.h"
#include "verify/invariants/invariants.h"

namespace scotty::verify {

using reference::StageKind;

const std::vector<std::string>& invariants_of(StageKind kind) {
    using namespace invariant;  // in this function only: their names
    static const std::vector<std::string> scan{kNonFinite, kHandOver, kScan};
    static const std::vector<std::string> level{kNonFinite,       kHandOver,    kCountEqualsPushes,
                                                kSlotWrittenOnce, kNoDuplicate, kNothingExtra,
                                                kRequiredPresent, kInputOrder,  kConservation,
                                                kLeafHits,        kMinimum};
    static const std::vector<std::string> minimum{kNonFinite, kMinimum};
    static const std::vector<std::string> merge{kNonFinite, kHandOver, kMerge, kRequiredPresent};
    static const std::vector<std::string> primary{kNonFinite, kRayRecord, kPathState, kPixels};
    static const std::vector<std::string> light{kNonFinite, kHandOver, kRayRecord, kPathState};
    static const std::vector<std::string> resolve{kNonFinite, kHandOver, kResolveLight};
    static const std::vector<std::string> image{kNonFinite, kHandOver, kPixels};
    static const std::vector<std::string> finite{kNonFinite};
    switch (kind) {
        case StageKind::scan_counts:
            return scan;
        case StageKind::intersect_root:
        case StageKind::intersect:
            return level;
        case StageKind::publish_minimum:
            return minimum;
        case StageKind::merge_intersections:
            return merge;
        case StageKind::primary_rays:
            return primary;
        case StageKind::direct_light_rays:
        case StageKind::scene_rays:
            return light;
        case StageKind::resolve_light:
            return resolve;
        case StageKind::reconstruct_image:
            return image;
        case StageKind::filter:
            break;
    }
    return finite;
}

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
