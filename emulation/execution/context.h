/// What the running CUDA thread knows of itself. One per worker: a block stays on one worker.
#pragma once

#include <coroutine>
#include <csetjmp>
#include <cstdint>

#include "emulation/execution/shared_memory.h"
#include "emulation/execution/site.h"

namespace scotty::emulation::simt {

constexpr std::uint32_t kLanes = 32;
/// A thread or block that is not known.
constexpr std::uint32_t kSomeOther = ~0u;

class MemoryChecker;  // check/memory_checker.h
class Interleaver;    // simt/interleave/interleaver.h
class FrameArena;     // simt/frame_arena.h
class LateStores;     // simt/late_stores.h
struct SharedShadow;

/// The place where a thread of the block has stopped.
struct ThreadStop {
    std::coroutine_handle<> handle;  ///< of its innermost coroutine
    const Site* site = nullptr;
};

struct Context {
    ThreadStop* stop = nullptr;  ///< the running thread's
    std::uint32_t thread = 0;
    std::uint32_t block = 0;
    std::uint32_t block_size = 0;
    std::uint32_t grid_size = 0;
    std::uint32_t lanes = 0;  ///< of the running warp: fewer than 32 in a short last warp
    /// The warp's collective: its lanes' contributions, and the last one's result.
    std::uint32_t ballot_in = 0;
    std::uint32_t ballot_out = 0;
    std::uint32_t* ballots_in = nullptr;
    std::uint32_t* ballots_out = nullptr;
    std::uint32_t* values_in = nullptr;
    std::uint32_t* values_out = nullptr;
    /// For collectives with a mask, by lane: the mask passed, 0 if the lane waits at none.
    std::uint32_t* masks = nullptr;
    bool masked = false;  ///< some lane of the warp may wait at one
    /// By thread of the block: the SCOTTY_RETURN that ended it, null for the kernel's end.
    const Site** returns = nullptr;
    std::uint32_t started = 0;
    std::uint32_t finished = 0;
    FrameArena* arena = nullptr;
    LateStores* late_stores = nullptr;  ///< null: every store is seen at once
    SharedMemory* shared = nullptr;
    std::uint32_t phase = 0;  ///< barriers that the block has passed
    /// The address in the text of the last access that instrumented code has announced.
    const void* last_access = nullptr;
    sigjmp_buf* way_out = nullptr;  ///< for a thread that reaches memory which is not there
    /// Hears of the accesses of instrumented kernels; null: nobody does.
    MemoryChecker* checker = nullptr;
    /// The same in a phase on registers, which has no accesses: Block::phase_on_registers.
    MemoryChecker* on_registers = nullptr;
    /// Hears of them instead where blocks are switched in their middle; null otherwise.
    Interleaver* interleaver = nullptr;
    std::uint32_t first_block = 0;          ///< of the launch, as the checker numbers it
    SharedShadow* shared_shadow = nullptr;  ///< of the block's shared memory
};

inline constinit thread_local Context context{};

}  // namespace scotty::emulation::simt
