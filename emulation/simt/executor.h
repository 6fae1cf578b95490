/// Runs kernels written in the dialect (docs/kernel-dialect.md), one coroutine per CUDA thread.
///
/// It runs the text of the CUDA kernels themselves, with barriers anywhere. Blocks run in parallel,
/// each on one worker, or one after the other in an order that replays.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/task_arena.h>

#include <cstdint>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "emulation/check/memory_checker.h"
#include "emulation/execution/schedule.h"
#include "emulation/simt/block_runner.h"
#include "emulation/simt/task.h"

namespace scotty::emulation::simt {

/// The same as the emulator's. An explicit order holds for blocks, warps and lanes; under `free`
/// threads take turns in ascending order.
using SimtOptions = DeviceOptions;

struct Grid {
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;       ///< per block
    std::size_t dynamic_shared = 0;  ///< bytes per block, beside what the kernel declares
};

/// One executor is used by one host thread at a time.
class Executor {
 public:
    explicit Executor(const SimtOptions& options = {});

    /// Runs all threads of the grid and returns when all have left. `threads` is 1..1024 per block.
    ///
    /// Throws LaunchError, naming kernel, block and threads, if threads of a block wait at
    /// different barriers, lanes of a warp at different stops, or some have left while others wait,
    /// and if a thread throws. The other blocks may or may not have run then.
    template <class... Parameters, class... Arguments>
    void launch(const char* name, std::uint32_t blocks, std::uint32_t threads,
                Kernel (*kernel)(Parameters...), Arguments&&... arguments) {
        launch(name, Grid{blocks, threads, 0}, kernel, std::forward<Arguments>(arguments)...);
    }
    template <class... Parameters, class... Arguments>
    void launch(const char* name, const Grid& grid, Kernel (*kernel)(Parameters...),
                Arguments&&... arguments) {
        static_assert((std::is_trivially_copyable_v<std::remove_reference_t<Parameters>> && ...),
                      "parameters of a kernel are copied to the device byte by byte");
        struct Call {
            Kernel (*kernel)(Parameters...);
            std::tuple<Parameters...> parameters;
        };
        const Call call{kernel, {std::forward<Arguments>(arguments)...}};
        Launch launch;
        launch.kernel = name;
        launch.blocks = grid.blocks;
        launch.threads = grid.threads;
        launch.dynamic_shared = grid.dynamic_shared;
        launch.arguments = &call;
        launch.start = [](const void* memory) {
            const auto& thread = *static_cast<const Call*>(memory);
            std::apply(thread.kernel, thread.parameters);
        };
        run(launch);
    }

    /// From now on the accesses of instrumented kernels are checked (check/). A finding fails its
    /// launch.
    void check_memory();
    /// Null without a checker.
    MemoryChecker* checker() const { return checker_.get(); }
    /// From now on the blocks of a launch are switched in their middle (interleave/); null ends
    /// that. It needs check_memory() and instrumented kernels, whose accesses are not checked
    /// meanwhile.
    void interleave(Interleaver* interleaver) { interleaver_ = interleaver; }
    /// Counts the threads that were started and have left, over all launches, each once.
    std::uint64_t threads_run() const;
    /// Counts the loads that have found a word as it was before its last store (late_stores.h).
    std::uint64_t late_loads() const { return late_loads_; }

 private:
    void run(Launch& launch);
    void run_blocks(Launch& launch);

    SimtOptions options_;
    std::unique_ptr<MemoryChecker> checker_;
    Interleaver* interleaver_ = nullptr;
    std::uint64_t late_loads_ = 0;
    std::uint64_t launches_ = 0;  ///< so that orders differ from launch to launch
    oneapi::tbb::task_arena arena_;
    oneapi::tbb::enumerable_thread_specific<BlockRunner> runners_;
};

}  // namespace scotty::emulation::simt
