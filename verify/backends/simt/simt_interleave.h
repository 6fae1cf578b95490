/// One stage of the CUDA text on the CPU, its blocks switched in their middle
/// (emulation/simt/interleave/).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "emulation/simt/interleave/explorer.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::simt {

/// What a stage needs to be run alone, as Pipeline::run_stage() takes it, and when two outcomes of
/// it are the same.
struct InterleavedStage {
    const reference::Scene& scene;
    const reference::WideBvh& bvh;
    const reference::PipelineParameters& parameters;
    const reference::StageView& stage;
    std::function<std::string(const std::vector<reference::OwnedBuffer>&)> canonical;
};

/// Every order, or those within a bound. Throws missing_environment in a program whose kernels are
/// not instrumented (checks_memory()).
emulation::simt::Exploration explore_simt_stage(const InterleavedStage& stage,
                                                const emulation::simt::ExploreOptions& options);
/// The outcome of one order.
std::string replay_simt_stage(const InterleavedStage& stage,
                              const emulation::simt::Interleaving& interleaving);

}  // namespace scotty::simt
