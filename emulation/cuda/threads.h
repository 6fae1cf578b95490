/// The threads and blocks of a running launch.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "emulation/cuda/clocks.h"
#include "emulation/cuda/findings.h"
#include "emulation/cuda/include/scotty_cuda/interface.h"
#include "emulation/cuda/shadow.h"
#include "emulation/cuda/stacks.h"

namespace scotty::emulation::cuda {

using scotty_cuda::Dim;
using scotty_cuda::WarpOperation;

constexpr std::uint32_t kWarp = 32;

enum class ThreadState : std::uint8_t {
    ready,
    at_barrier,
    at_warp_operation,
    left_early,   ///< by a return in the kernel's text
    left_at_end,  ///< behind the kernel's last line
};

struct Block;

/// A read of memory that nobody has written, which may turn out to be part of a record's copy.
struct UnsureRead {
    const std::byte* at = nullptr;
    Finding finding;
};

/// A write whose value is not known yet: whether a race wrote the same value is seen at the
/// thread's next stop or access.
struct OpenWrite {
    const std::byte* address = nullptr;
    std::array<std::byte, 16> before{};
    std::uint32_t bytes = 0;
    std::size_t finding = 0;
};

struct alignas(64) Thread {
    // What every turn touches is in one line of the cache.
    Stack* stack = nullptr;
    ThreadState state = ThreadState::ready;
    bool left_said = false;         ///< a return statement has announced itself
    bool waits_for_others = false;  ///< gave its turn away in a loop that polls
    std::uint8_t barrier = 0;       ///< plain, and, or, count
    std::uint32_t index = 0;        ///< in the block
    Dim at;                         ///< threadIdx
    std::uint32_t place = 0;        ///< where it stops or left, in the program's text
    std::uint32_t clock = 1;
    std::uint32_t polls = 0;     ///< atomics and volatile accesses since it last got its turn
    std::uint32_t accesses = 0;  ///< all accesses since then
    std::uint32_t value_of_barrier = 0;
    std::uint32_t result_of_barrier = 0;
    bool knows_more = false;  ///< has or had something of what follows, but for its block's base

    Block* block = nullptr;
    std::uint32_t stack_of_calls = 0;
    std::uint32_t last_place = 0;  ///< of its last access

    // What it waits with.
    WarpOperation operation = WarpOperation::sync;
    std::uint32_t mask = 0;
    std::uint64_t value = 0;
    std::uint32_t parameter = 0;
    std::uint32_t width = kWarp;
    std::uint64_t result = 0;
    bool result_flag = false;

    // What it knows.
    std::array<std::uint32_t, kWarp> known{};  ///< lanes of its warp: counts below these
    SharedClocks acquired;
    SharedClocks read;          ///< by atomics: acquired at the next fence
    SharedClocks fenced;        ///< at its last fence, which an atomic write passes on
    SharedClocks fenced_block;  ///< the same for fences that hold for the block only

    bool is_heard = true;  ///< its accesses are looked at
    std::vector<OpenWrite> open_writes;
    std::vector<UnsureRead> unsure_reads;  ///< of the running function

    std::uint32_t lane() const { return index % kWarp; }
    std::uint32_t warp() const { return index / kWarp; }
    bool has_left() const {
        return state == ThreadState::left_early || state == ThreadState::left_at_end;
    }
};

/// A shared object of a block and where its text stands.
struct SharedObject {
    const void* site = nullptr;
    Region region;
};

struct Block {
    std::uint32_t index = 0;  ///< in the grid
    Dim at;                   ///< blockIdx
    std::vector<Thread> threads;
    std::uint32_t base = 1;  ///< everything at lower counts was before its last barrier
    bool abandoned = false;
    bool asks_active = false;    ///< some thread waits in __activemask
    bool has_left = false;       ///< some thread has
    bool waits_in_warp = false;  ///< some lane of the warp that has run does
    bool begun = false;
    std::uint64_t pass = 0;

    std::vector<std::byte> shared;  ///< with gaps between its objects
    std::vector<Cell> cells;
    std::vector<std::uint8_t> unwritten;
    std::vector<SharedObject> objects;
    std::size_t shared_used = 0;

    bool holds_shared(const std::byte* at_byte) const {
        return at_byte >= shared.data() && at_byte < shared.data() + shared.size();
    }
};

}  // namespace scotty::emulation::cuda
