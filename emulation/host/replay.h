/// Runs one stage alone, on buffers that came from elsewhere, with the pipeline's own kernels.
#pragma once

#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

/// What the kernel of `stage` makes of stage.inputs, by the names that the pipeline shows; besides,
/// "lowered" of an intersect under early-out `level` and "minimum" under `immediate`.
///
/// The inputs hold what the pipeline shows and, under the names of the outputs, what is updated in
/// place as it was before the launch (docs/captures.md). stage.outputs is not looked at. Memory
/// that the kernel leaves alone holds 0xffffffff, or (+infinity, 0xffffffff) in hit lists.
/// Throws bad_input naming stage and buffer: missing, of another size than the others imply, or
/// leading the kernel out of a buffer.
std::vector<reference::OwnedBuffer> run_stage(const reference::Scene& scene,
                                              const reference::WideBvh& bvh,
                                              const reference::PipelineParameters& parameters,
                                              const DeviceOptions& options,
                                              const reference::StageView& stage);

}  // namespace scotty::emulation
