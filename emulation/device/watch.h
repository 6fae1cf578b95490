/// What the virtual device tells the checker of loads and stores (docs/checking.md).
///
/// In the checked build (scotty-checked) check/watch_checked.h replaces these. Everywhere else they
/// are empty and cost nothing.
#pragma once

#include "emulation/execution/buffer_use.h"

#if defined(SCOTTY_CHECKED)

#include "emulation/check/watch_checked.h"

#else

#include <cstddef>
#include <cstdint>
#include <memory>

#include "emulation/execution/schedule.h"
#include "reference/contract/launch_record.h"

namespace scotty::emulation {

/// The watch of one device.
class Watch {
 public:
    /// Lives while a block runs on a worker.
    struct InBlock {
        InBlock(Watch&, std::uint32_t /*index*/, std::uint32_t /*threads*/) {}
    };
    template <class Run>
    void run_launch(std::uint32_t /*blocks*/, std::uint32_t /*threads*/, const Schedule&,
                    std::uint64_t /*launch*/, const Run& run) {
        run();
    }

    /// Names the launches of this host thread from now on.
    static void name_launch(reference::StageKind, const reference::StagePlace&,
                            std::size_t /*launch*/) {}
    static void begin_phase() {}
    static void end_phase() {}
    static void begin_thread(std::uint32_t /*thread*/) {}
    static void end_turn() {}
    static void begin_registers() {}
    static void end_registers() {}
    /// Runs the threads of a phase.
    template <class Body>
    static void each_thread(std::uint32_t active, Body& body) {
        for (std::uint32_t thread = 0; thread < active; ++thread) body(thread);
    }
    /// Idle threads run along, up to a whole vector, as those of a warp do: what is in their
    /// registers means nothing, and loops need no remainder. PerThread has room for them.
    template <class Body>
    static void each_thread_on_registers(std::uint32_t active, Body& body) {
        constexpr std::uint32_t kVector = 8;
        each_thread((active + kVector - 1) / kVector * kVector, body);
    }
    template <class Kernel, class Block>
    static void run_block(Kernel& kernel, const Block& block) {
        kernel(block);
    }
    static void own_register(std::uint32_t /*thread*/) {}
};

/// A device's memory.
template <class T>
struct WatchedMemory {
    using Pointer = std::unique_ptr<T[]>;
    static Pointer allocate(Watch*, std::size_t count, const char* /*name*/, BufferUse) {
        return Pointer(new T[count]);
    }
    static void host_wrote(Watch*, const T*, std::size_t) {}
    static void discard(Watch*, const T*, std::size_t, BufferUse) {}
};

/// A block's shared memory, on the worker's stack. It is one cache line longer than needed: see
/// PerThread.
template <class T, std::uint32_t Count>
struct WatchedShared {
    explicit WatchedShared(const char* /*name*/) {}
    alignas(64) T values[Count + 64 / sizeof(T)];
};

}  // namespace scotty::emulation

#endif
