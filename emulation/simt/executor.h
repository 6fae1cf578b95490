/// Runs kernels written in the dialect (docs/kernel-dialect.md), one coroutine per CUDA thread.
///
/// Exact tier (docs/design.md): the text of the CUDA kernels themselves, with barriers anywhere.
/// Blocks run in parallel, each on one worker, or one after the other in an order that replays.
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

/// As the volume tier's. An explicit order holds for blocks, warps and lanes; under `free` threads
/// take turns in ascending order.
using SimtOptions = DeviceOptions;

struct Grid {
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;       ///< a block
    std::size_t dynamic_shared = 0;  ///< bytes a block, beside what the kernel declares
};

/// One executor is used by one host thread at a time.
class Executor {
 public:
    explicit Executor(const SimtOptions& options = {});

    /// Runs all threads of the grid and returns when all have left. `threads` is 1..1024 a block.
    ///
    /// Throws LaunchError, naming kernel, block and threads: when threads of a block stand at
    /// different barriers, or lanes of a warp at different stops, or some have left while others
    /// wait, and when a thread throws. The other blocks may or may not have run then.
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

    /// From now on what kernels touch is checked, where they are instrumented for it (check/). A
    /// finding fails its launch.
    void check_memory();
    /// Null where nothing is checked.
    MemoryChecker* checker() const { return checker_.get(); }
    /// From now on the blocks of a launch are switched in their middle (interleave/); null: no
    /// more. Needs check_memory() and instrumented kernels. What they touch is not checked
    /// meanwhile.
    void interleave(Interleaver* interleaver) { interleaver_ = interleaver; }
    /// Threads that were started and have left, over all launches: each once.
    std::uint64_t threads_run() const;

 private:
    void run(Launch& launch);
    void run_blocks(const Launch& launch);

    SimtOptions options_;
    std::unique_ptr<MemoryChecker> checker_;
    Interleaver* interleaver_ = nullptr;
    std::uint64_t launches_ = 0;  ///< so that orders differ from launch to launch
    oneapi::tbb::task_arena arena_;
    oneapi::tbb::enumerable_thread_specific<BlockRunner> runners_;
};

}  // namespace scotty::emulation::simt
