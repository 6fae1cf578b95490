/// Everything that one stage of a capture needs to be run on its own.
///
/// A stage's inputs are in its record, but not what it updates in place (hits gathered so far,
/// radiance, path state) as that was before the launch, nor what is read by every shading kernel
/// (pixel, sample). Those come from the stage that wrote them last.
#pragma once

#include "verify/capture/capture.h"

namespace scotty::verify {

/// The stage as captured; its inputs also hold, under the names of its outputs, the values before
/// the launch: "hit_counts", "hits", "packed_hits", "lowered" (early-out level), "minimum" (as read
/// under `immediate`), "radiance", "rays", "throughput", "flags", "depth", "pixel", "sample",
/// "image". Each name is there once. Outputs are the captured ones, to compare with.
/// Throws bad_input naming the stage that would have to be captured too.
LoadedStage prepare_stage(const Capture& capture, const StageRecord& stage);

}  // namespace scotty::verify
