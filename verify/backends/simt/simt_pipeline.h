/// The CUDA pipeline of gpu/, host side and kernels, run on the CPU: one coroutine per CUDA thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "emulation/simt/executor.h"
#include "gpu/host/pipeline.h"

namespace scotty::simt {

using emulation::simt::SimtOptions;

/// Whether this program checks every load and store of the kernels, of the emulator and of the CUDA
/// text (emulation/check/): one that was built to (scotty-checked, scotty-mutants) does, until told
/// not to.
bool checks_memory();
void watch_memory(bool on);

/// Who wrote what an observer is being shown.
struct WrittenBy {
    std::string kernel;
    bool in_this_launch;
    std::uint32_t block, thread;
    std::string line;  ///< "gpu/kernels/intersect.h:107"
};
/// By the address in a buffer of the stage that the observer, which calls this, has just been
/// handed. None where nothing is checked, or no kernel wrote there.
std::optional<WrittenBy> written_by(const void* shown);

/// As gpu::make_pipeline, with the same text behind it; needs no device. A kernel whose threads do
/// not meet or that fails is an internal error naming launch, kernel, block and threads.
std::unique_ptr<gpu::Pipeline> make_simt_pipeline(const reference::Scene& scene,
                                                  const reference::WideBvh& bvh,
                                                  const reference::PipelineParameters& parameters,
                                                  const SimtOptions& options = {},
                                                  reference::StageObserver* observer = nullptr,
                                                  const gpu::PipelineOptions& pipeline = {});

}  // namespace scotty::simt
