/// Runs one block of CUDA threads on one worker.
///
/// Warps take turns: every lane runs to its next stop; a warp whose lanes all wait at one
/// collective gets its result and goes on, until it waits at a barrier or has left. When all warps
/// wait at one barrier, the next phase begins. Anything else is a divergence.
#pragma once

#include <array>
#include <coroutine>
#include <cstdint>
#include <string>
#include <vector>

#include "emulation/check/memory_checker.h"
#include "emulation/execution/context.h"
#include "emulation/execution/launch_error.h"
#include "emulation/execution/schedule.h"
#include "emulation/execution/thread_order.h"
#include "emulation/simt/frame_arena.h"

namespace scotty::emulation::simt {

/// A kernel with its arguments, and the grid.
struct Launch {
    const char* kernel = "";
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;                       ///< per block
    std::size_t dynamic_shared = 0;                  ///< bytes per block
    void (*start)(const void* arguments) = nullptr;  ///< runs one thread to its first stop
    const void* arguments = nullptr;
    MemoryChecker* checker = nullptr;
    Interleaver* interleaver = nullptr;
    LateStores* late_stores = nullptr;
    std::uint32_t first_block = 0;  ///< as the checker numbers it
};

class BlockRunner {
 public:
    /// Throws LaunchError; the block is then abandoned, and its other threads stay where they are.
    void run(const Launch& launch, std::uint32_t block, ScheduleKind order, std::uint64_t seed);

    std::uint64_t threads_run() const { return threads_run_; }

 private:
    void enter(const Launch& launch, std::uint32_t block);
    static void leave();
    /// Runs the warp up to a barrier or its end. Returns false where its lanes do not meet.
    template <bool First>
    bool run_warp(const Launch& launch, std::uint32_t warp);
    /// Lets those lanes go on whose mask's lanes all wait there too. Returns false if none can.
    bool run_masked(const Launch& launch, std::uint32_t base, std::uint32_t lanes);
    template <bool First>
    void run_phase(const Launch& launch);
    [[noreturn]] void fail_mask(const Launch& launch, std::uint32_t thread,
                                std::uint32_t mask) const;
    [[noreturn]] void fail_divergent(const Launch& launch) const;
    /// Called inside a handler: reports what the running thread has thrown.
    [[noreturn]] void fail_thread(const Launch& launch) const;

    std::array<ThreadStop, kMaxThreads> stops_{};
    std::array<const Site*, kMaxThreads> returns_{};
    std::array<std::array<std::uint32_t, kLanes>, 2> values_{};
    std::array<std::array<std::uint32_t, kLanes>, 2> ballots_{};
    std::array<std::uint32_t, kLanes> masks_{};
    ThreadOrder order_;
    FrameArena arena_;
    SharedMemory shared_;
    std::vector<SharedShadow> shared_shadow_;  ///< used where there is a checker
    std::uint64_t threads_run_ = 0;
};

}  // namespace scotty::emulation::simt
