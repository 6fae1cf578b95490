/// What the running CUDA thread knows of itself. One per worker: a block stays on one worker.
#pragma once

#include <coroutine>
#include <cstddef>
#include <cstdint>

#include "emulation/simt/frame_arena.h"
#include "emulation/simt/shared_memory.h"
#include "emulation/simt/site.h"

namespace scotty::emulation::simt {

constexpr std::uint32_t kLanes = 32;

/// The place for a checker of memory accesses. It hears of what the dialect's functions touch and
/// of every barrier; plain loads and stores of a kernel go through no function, and are the
/// compiler's to report (instrumented code calls back, and `context` says which thread it was).
class AccessObserver {
 public:
    enum class Access : std::uint8_t { read, relaxed_read, atomic };
    AccessObserver() = default;
    AccessObserver(const AccessObserver&) = delete;
    AccessObserver& operator=(const AccessObserver&) = delete;
    virtual ~AccessObserver() = default;

    /// By the thread that `context` names.
    virtual void on_access(Access access, const void* address, std::size_t bytes) = 0;
    /// All threads of the block have come to the barrier.
    virtual void on_barrier(std::uint32_t block, const Site& site) = 0;
};

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
    /// The warp's collective: what lanes bring, and what the last one made of it.
    std::uint32_t ballot_in = 0;
    std::uint32_t ballot_out = 0;
    std::uint32_t* ballots_in = nullptr;
    std::uint32_t* ballots_out = nullptr;
    std::uint32_t* values_in = nullptr;
    std::uint32_t* values_out = nullptr;
    /// By thread of the block: the SCOTTY_RETURN that ended it; null: the kernel's end.
    const Site** returns = nullptr;
    std::uint32_t started = 0;
    std::uint32_t finished = 0;
    FrameArena* arena = nullptr;
    SharedMemory* shared = nullptr;
    const char* kernel = nullptr;  ///< null while none runs
    AccessObserver* observer = nullptr;
};

inline constinit thread_local Context context{};

inline void note_access(AccessObserver::Access access, const void* address, std::size_t bytes) {
    if (context.observer != nullptr) [[unlikely]] {
        context.observer->on_access(access, address, bytes);
    }
}

}  // namespace scotty::emulation::simt
