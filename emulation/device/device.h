/// The virtual device: grids of blocks, blocks of threads, run in phases on TBB.
///
/// A kernel is a function of one Block. Blocks run in parallel and in any order; inside a block
/// every thread finishes a phase before any starts the next, which is what a barrier means. Shared
/// memory is an object on the worker's stack; atomics on global memory are real atomics
/// (atomics.h). In the checked build every access is watched (watch.h).
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "emulation/device/watch.h"
#include "emulation/execution/schedule.h"

namespace scotty::emulation {

/// The running thread in a phase on registers, which reaches its own registers unannounced.
class OwnThread {
 public:
    explicit OwnThread(std::uint32_t index) : index_(index) {}
    operator std::uint32_t() const { return index_; }  // NOLINT(google-explicit-constructor)

 private:
    std::uint32_t index_;
};

/// One value per thread of a block that lives across phases, as a register does on the device. Only
/// its own thread may touch it; threads hand values to each other through Shared. It is
/// uninitialised, as registers are, and one cache line longer than needed: arrays a page apart
/// would all fall into the same sets of the first-level cache.
template <class T>
struct PerThread {
    alignas(64) T values[kMaxThreads + 64 / sizeof(T)];
    T& operator[](std::uint32_t thread) {
        Watch::own_register(thread);
        return values[thread];
    }
    const T& operator[](std::uint32_t thread) const {
        Watch::own_register(thread);
        return values[thread];
    }
    T& operator[](OwnThread thread) { return values[thread]; }
    const T& operator[](OwnThread thread) const { return values[thread]; }
};

/// Shared memory of a block: its threads hand values to each other here from phase to phase, as in
/// SCOTTY_SHARED. A kernel declares it, uninitialised; reports use `name`.
template <class T, std::uint32_t Count = kMaxThreads>
class Shared {
 public:
    explicit Shared(const char* name) : memory_(name) {}
    Shared(const Shared&) = delete;
    Shared& operator=(const Shared&) = delete;
    T& operator[](std::uint32_t index) { return memory_.values[index]; }
    const T& operator[](std::uint32_t index) const { return memory_.values[index]; }

 private:
    WatchedShared<T, Count> memory_;
};

/// A kernel's view of its place in the grid.
class Block {
 public:
    Block(std::uint32_t index, std::uint32_t threads) : index_(index), threads_(threads) {}

    std::uint32_t index() const { return index_; }      ///< blockIdx
    std::uint32_t threads() const { return threads_; }  ///< blockDim
    std::uint32_t global_thread(std::uint32_t thread) const { return index_ * threads_ + thread; }

    /// A phase: `body(thread)` for the first `active` threads; the others idle to the barrier that
    /// ends it. Threads of one phase must not depend on each other (loops may vectorise), and only
    /// the last three functions below hand values from one to the next.
    template <class Body>
    void phase(std::uint32_t active, Body&& body) const {
        Watch::begin_phase();
        Watch::each_thread(active, body);
        Watch::end_phase();
    }
    template <class Body>
    void phase(Body&& body) const {
        phase(threads_, body);
    }
    /// A phase whose threads touch only registers and values of the block that no kernel can
    /// change, and no memory: `body(OwnThread)`. It vectorises under the checker too, which reports
    /// any access to memory.
    template <class Body>
    void phase_on_registers(std::uint32_t active, Body&& body) const {
        Watch::begin_phase();
        Watch::begin_registers();
        const auto run = [&](std::uint32_t thread) { body(OwnThread(thread)); };
        Watch::each_thread_on_registers(active, run);
        Watch::end_registers();
        Watch::end_phase();
    }
    /// A phase in which only thread 0 works.
    template <class Body>
    void phase_thread_zero(Body&& body) const {
        Watch::begin_phase();
        body();
        Watch::end_phase();
    }
    /// Threads take turns in ascending order, each with a barrier before and after it, so a running
    /// total may go from one to the next. On the device this is a scan or a ballot.
    template <class Body>
    void phase_in_order(std::uint32_t active, Body&& body) const {
        Watch::begin_phase();
        for (std::uint32_t thread = 0; thread < active; ++thread) {
            Watch::begin_thread(thread);
            body(thread);
            Watch::end_turn();
        }
        Watch::end_phase();
    }
    /// Counts how many of the first `active` threads say yes: __syncthreads_count.
    template <class Predicate>
    std::uint32_t count(std::uint32_t active, Predicate&& predicate) const {
        std::uint32_t total = 0;
        phase(active, [&](std::uint32_t thread) { total += predicate(thread) ? 1u : 0u; });
        return total;
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
        const Schedule schedule{options_.schedule, options_.schedule_seed};
        const auto run = [&](std::uint32_t index) {
            const Watch::InBlock watched(watch_, index, threads);
            watch_.run_block(kernel, Block(index, threads));
        };
        watch_.run_launch(blocks, threads, schedule, ++launches_, [&] {
            if (schedule.kind != ScheduleKind::free) {
                for (const std::uint32_t i : block_order(schedule, launches_, blocks)) run(i);
                return;
            }
            arena_.execute([&] {
                oneapi::tbb::parallel_for(
                    oneapi::tbb::blocked_range<std::uint32_t>(0, blocks, grain(threads)),
                    [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
                        for (std::uint32_t i = range.begin(); i != range.end(); ++i) run(i);
                    });
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

    /// For DeviceBuffer.
    Watch& watch() { return watch_; }

 private:
    /// Blocks that a worker takes at once: about a thousand threads' work.
    static std::uint32_t grain(std::uint32_t threads) {
        return std::max<std::uint32_t>(1, 1024 / threads);
    }

    DeviceOptions options_;
    std::uint64_t launches_ = 0;  ///< so that a schedule differs from launch to launch
    oneapi::tbb::task_arena arena_;
    Watch watch_;
};

}  // namespace scotty::emulation
