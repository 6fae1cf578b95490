#include "emulation/host/replay.h"

#include "emulation/host/replay_stages.h"
#include "reference/base/assert.h"

namespace scotty::emulation {

using reference::StageKind;

std::vector<reference::OwnedBuffer> run_stage(const reference::Scene& scene,
                                              const reference::WideBvh& bvh,
                                              const reference::PipelineParameters& parameters,
                                              const DeviceOptions& options,
                                              const reference::StageView& stage) {
    SCOTTY_ASSERT(bvh.width, ==, parameters.width);
    Device device(options);
    ReplayStage run{view_of(scene), bvh, parameters, stage, device, reference::StageBuffers(stage)};
    switch (stage.kind) {
        case StageKind::primary_rays:
            replay_primary_rays(run);
            break;
        case StageKind::scan_counts:
            replay_scan_counts(run);
            break;
        case StageKind::intersect_root:
        case StageKind::intersect:
            replay_intersect(run);
            break;
        case StageKind::publish_minimum:
            replay_publish_minimum(run);
            break;
        case StageKind::merge_intersections:
            replay_merge_intersections(run);
            break;
        case StageKind::direct_light_rays:
            replay_direct_light_rays(run);
            break;
        case StageKind::resolve_light:
            replay_resolve_light(run);
            break;
        case StageKind::scene_rays:
            replay_scene_rays(run);
            break;
        case StageKind::reconstruct_image:
            replay_reconstruct_image(run);
            break;
        case StageKind::filter:
            replay_filter(run);
            break;
    }
    return std::move(run.buffers).take();
}

}  // namespace scotty::emulation
