#include "verify/backends/simt/simt_interleave.h"

#include "emulation/simt/current_device.h"
#include "gpu/host/pipeline_build.h"
#include "reference/base/error.h"
#include "verify/backends/simt/simt_pipeline.h"

namespace scotty::simt {

using emulation::simt::CurrentDevice;
using emulation::simt::Executor;
using emulation::simt::Interleaver;

namespace {

/// An executor under the checker's memory, and the stage on it.
class StageOnExecutor {
 public:
    explicit StageOnExecutor(const InterleavedStage& stage) : stage_(stage) {
        if (!checks_memory()) {
            throw reference::Error::missing_environment(
                "interleaving: only scotty-checked has kernels that say what they touch; use "
                "--check");
        }
        executor_.check_memory();
    }

    const emulation::simt::MemoryChecker& memory() const { return *executor_.checker(); }
    emulation::simt::InterleavedRun run() {
        return [this](Interleaver& interleaver) {
            const CurrentDevice here(executor_);
            CurrentDevice::launch_failure().clear();
            executor_.checker()->forget_all();  // so that a word is the same word in every run
            executor_.interleave(&interleaver);
            return stage_.canonical(
                gpu::simt::make_pipeline(stage_.scene, stage_.bvh, stage_.parameters, {}, nullptr)
                    ->run_stage(stage_.stage));
        };
    }

 private:
    const InterleavedStage& stage_;
    Executor executor_;
};

}  // namespace

emulation::simt::Exploration explore_simt_stage(const InterleavedStage& stage,
                                                const emulation::simt::ExploreOptions& options) {
    StageOnExecutor on(stage);
    return explore(on.memory(), on.run(), options);
}

std::string replay_simt_stage(const InterleavedStage& stage,
                              const emulation::simt::Interleaving& interleaving) {
    StageOnExecutor on(stage);
    return replay(on.memory(), on.run(), interleaving);
}

}  // namespace scotty::simt
