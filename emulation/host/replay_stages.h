/// One function a stage kind. Each reads its inputs by name, launches its kernel, names the
/// outputs.
#pragma once

#include "emulation/device/device.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_inputs.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

struct ReplayStage {
    reference::SceneView scene;
    const reference::WideBvh& bvh;
    const reference::PipelineParameters& parameters;
    const reference::StageView& stage;
    Device& device;
    reference::StageBuffers buffers;
};

void replay_primary_rays(ReplayStage& run);
void replay_scan_counts(ReplayStage& run);
void replay_intersect(ReplayStage& run);  ///< intersect_root too
void replay_publish_minimum(ReplayStage& run);
void replay_merge_intersections(ReplayStage& run);
void replay_direct_light_rays(ReplayStage& run);
void replay_resolve_light(ReplayStage& run);
void replay_scene_rays(ReplayStage& run);
void replay_reconstruct_image(ReplayStage& run);
void replay_filter(ReplayStage& run);

}  // namespace scotty::emulation
