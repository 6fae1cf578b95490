/// The virtual device: grids of blocks, blocks of threads, run in phases on TBB.
///
/// Volume tier (docs/design.md): a kernel is a function of one Block. Blocks run in parallel and in
/// any order; inside a block every thread finishes a phase before any starts the next, which is
/// what a barrier means. Shared memory is an object on the worker's stack; atomics on global
/// memory are real atomics.
#pragma once

#include <cstddef>
#include <cstdint>

namespace scotty::emulation {

/// In which order the blocks of a launch start.
enum class ScheduleKind { free, linear, reversed, shuffled };

struct DeviceOptions {
    std::size_t threads = 0;  ///< worker threads; 0: all of the machine
    /// free: TBB decides. The others run one block after the other in the stated order.
    ScheduleKind schedule = ScheduleKind::free;
    std::uint64_t schedule_seed = 0;  ///< for shuffled
};

}  // namespace scotty::emulation
