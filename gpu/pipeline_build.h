/// What one build of the kernels offers to make_pipeline() and run_stage() of pipeline.h.
#pragma once

#include "gpu/dialect.h"
#include "gpu/pipeline.h"

namespace SCOTTY_DEVICE_NAMESPACE {

std::unique_ptr<Pipeline> make_pipeline(const reference::Scene& scene,
                                        const reference::WideBvh& bvh,
                                        const reference::PipelineParameters& parameters,
                                        const PipelineOptions& options,
                                        reference::StageObserver* observer);

std::vector<reference::OwnedBuffer> run_stage(const reference::Scene& scene,
                                              const reference::WideBvh& bvh,
                                              const reference::PipelineParameters& parameters,
                                              const reference::StageView& stage);

}  // namespace SCOTTY_DEVICE_NAMESPACE
