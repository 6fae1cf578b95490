/// What the running CUDA thread knows of itself. One per worker: a block stays on one worker.
#pragma once

#include <coroutine>
#include <csetjmp>
#include <cstdint>

#include "emulation/execution/shared_memory.h"
#include "emulation/execution/site.h"

namespace scotty::emulation::simt {

constexpr std::uint32_t kLanes = 32;
/// Of a thread or block: which one is not known.
constexpr std::uint32_t kSomeOther = ~0u;

class MemoryChecker;  // check/memory_checker.h
class Interleaver;    // simt/interleave/interleaver.h
class FrameArena;     // simt/frame_arena.h
struct SharedShadow;

/// Where a thread of the block stands.
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
    std::uint32_t lanes = 0;  ///< of the running warp: fewer than 32 where the block ends in it
    /// The warp's collective: what lanes bring, and what the last one made of it.
    std::uint32_t ballot_in = 0;
    std::uint32_t ballot_out = 0;
    std::uint32_t* ballots_in = nullptr;
    std::uint32_t* ballots_out = nullptr;
    std::uint32_t* values_in = nullptr;
    std::uint32_t* values_out = nullptr;
    /// Of collectives with a mask, by lane: what the lane has passed, 0 where it stands at none.
    std::uint32_t* masks = nullptr;
    bool masked = false;  ///< some lane of the warp may stand at one
    /// By thread of the block: the SCOTTY_RETURN that ended it; null: the kernel's end.
    const Site** returns = nullptr;
    std::uint32_t started = 0;
    std::uint32_t finished = 0;
    FrameArena* arena = nullptr;
    SharedMemory* shared = nullptr;
    std::uint32_t phase = 0;  ///< barriers that the block has passed
    /// Where instrumented code was about to access memory when it last was: an address in its text.
    const void* last_access = nullptr;
    sigjmp_buf* way_out = nullptr;  ///< of a thread that reaches for memory which is not there
    /// Who hears of the accesses of instrumented kernels; null: nobody.
    MemoryChecker* checker = nullptr;
    /// The same in a phase on registers, where there is nothing to hear: Block::phase_on_registers.
    MemoryChecker* on_registers = nullptr;
    /// Who hears of them instead, where blocks take turns in their middle; null: they do not.
    Interleaver* interleaver = nullptr;
    std::uint32_t first_block = 0;          ///< of the launch, to the checker
    SharedShadow* shared_shadow = nullptr;  ///< of the block's shared memory
};

inline constinit thread_local Context context{};

}  // namespace scotty::emulation::simt
