/// The virtual device: grids of blocks, blocks of threads, run in phases on TBB.
///
/// Volume tier (docs/design.md): a kernel is a function of one Block. Blocks run in parallel and in
/// any order; inside a block every thread finishes a phase before any starts the next, which is
/// what a barrier means. Shared memory is an object on the worker's stack; atomics on global
/// memory are real atomics (atomics.h).
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scotty::emulation {

/// Threads a block may have, as on every CUDA device.
constexpr std::uint32_t kMaxThreads = 1024;

/// In which order the blocks of a launch start.
enum class ScheduleKind { free, linear, reversed, shuffled };

struct DeviceOptions {
    std::size_t threads = 0;  ///< worker threads; 0: all of the machine
    /// free: TBB decides. The others run one block after the other in the stated order.
    ScheduleKind schedule = ScheduleKind::free;
    std::uint64_t schedule_seed = 0;  ///< for shuffled
};

/// One value per thread of a block that lives across phases: what a register is on the device.
/// Uninitialised, as registers are. One cache line longer than it needs: arrays a page apart would
/// all fall into the same sets of the first-level cache.
template <class T>
struct PerThread {
    alignas(64) T values[kMaxThreads + 64 / sizeof(T)];
    T& operator[](std::uint32_t thread) { return values[thread]; }
    const T& operator[](std::uint32_t thread) const { return values[thread]; }
};

/// What a kernel sees of its place in the grid.
class Block {
 public:
    Block(std::uint32_t index, std::uint32_t threads) : index_(index), threads_(threads) {}

    std::uint32_t index() const { return index_; }      ///< blockIdx
    std::uint32_t threads() const { return threads_; }  ///< blockDim
    std::uint32_t global_thread(std::uint32_t thread) const { return index_ * threads_ + thread; }

    /// A phase: `body(thread)` for the first `active` threads; the others idle to the barrier that
    /// ends it. Threads of one phase must not depend on each other (loops may vectorise).
    template <class Body>
    void phase(std::uint32_t active, Body&& body) const {
        for (std::uint32_t thread = 0; thread < active; ++thread) body(thread);
    }
    template <class Body>
    void phase(Body&& body) const {
        phase(threads_, body);
    }
    /// A phase in which only thread 0 works.
    template <class Body>
    void phase_thread_zero(Body&& body) const {
        body();
    }

 private:
    std::uint32_t index_;
    std::uint32_t threads_;
};

/// Runs grids of blocks. One device is used by one host thread at a time.
class Device {
 public:
    explicit Device(const DeviceOptions& options);

    /// Runs `kernel(Block)` for every block and returns when all are done.
    template <class Kernel>
    void launch(std::uint32_t blocks, std::uint32_t threads, Kernel&& kernel) {
        if (options_.schedule != ScheduleKind::free) {
            for (const std::uint32_t index : block_order(blocks)) kernel(Block(index, threads));
            return;
        }
        arena_.execute([&] {
            oneapi::tbb::parallel_for(
                oneapi::tbb::blocked_range<std::uint32_t>(0, blocks, grain(threads)),
                [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
                    for (std::uint32_t i = range.begin(); i != range.end(); ++i) {
                        kernel(Block(i, threads));
                    }
                });
        });
    }

    /// Runs one thread per item in blocks of 256: `kernel(item)`.
    template <class Kernel>
    void launch_per_item(std::uint32_t items, Kernel&& kernel) {
        constexpr std::uint32_t kThreads = 256;
        launch((items + kThreads - 1) / kThreads, kThreads, [&](const Block& block) {
            const std::uint32_t first = block.index() * kThreads;
            block.phase(std::min(kThreads, items - first),
                        [&](std::uint32_t thread) { kernel(first + thread); });
        });
    }

 private:
    /// Blocks a worker takes at once: about a thousand threads' work.
    static std::uint32_t grain(std::uint32_t threads) {
        return std::max<std::uint32_t>(1, 1024 / threads);
    }
    std::vector<std::uint32_t> block_order(std::uint32_t blocks);

    DeviceOptions options_;
    std::uint64_t launches_ = 0;  ///< so that a shuffled schedule differs from launch to launch
    oneapi::tbb::task_arena arena_;
};

}  // namespace scotty::emulation
