/// The pipeline's paths through somebody else's traversal.
#pragma once

#include "reference/contract/image.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/truth/tracers.h"

namespace scotty::reference {

/// Renders path by path: the same text of the shading stages (reference/stages/), in a plain loop,
/// with Embree finding the primitives. No queues, no levels, no kernels. It judges traversal and
/// scheduling; a fault in the stages' text is a fault of this renderer, too. Where Embree and we
/// name the same primitive the distance and barycentrics are ours, so the image is equal bit for
/// bit except in pixels where Embree sees another hit. Filters are not applied. `threads` 0: all.
/// With an observer the render goes in batches as a pipeline's does, and each is shown as a
/// reconstruct_image that has the buffers pixel and image.
Image render_with_embree(const Scene& scene, const PipelineParameters& parameters,
                         const EmbreeTracer& tracer, std::size_t threads = 0,
                         StageObserver* observer = nullptr);

}  // namespace scotty::reference
