/// What one build of the kernels offers to make_pipeline() of pipeline.h.
#pragma once

#include "gpu/host/pipeline.h"
#include "gpu/kernels/dialect.h"

namespace scotty::gpu {

using MakePipeline = std::unique_ptr<Pipeline>(const reference::Scene&, const reference::WideBvh&,
                                               const reference::PipelineParameters&,
                                               const PipelineOptions&, reference::StageObserver*);

}  // namespace scotty::gpu

namespace SCOTTY_DEVICE_NAMESPACE {

MakePipeline make_pipeline;

}  // namespace SCOTTY_DEVICE_NAMESPACE
