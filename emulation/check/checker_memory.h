/// The simulated device's memory, and what the checker knows of each of its words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "emulation/check/mapped_memory.h"

namespace scotty::emulation::simt {

/// Who touched a word. The upper half is the block, counted from 1 over all launches, so that a
/// number below the launch's first belongs to an earlier launch; the lower half is phase << 12 |
/// several blocks | several threads | thread. 0: nobody.
using Stamp = std::uint64_t;
constexpr Stamp kThreadOfStamp = 0x3ff;
constexpr Stamp kSeveralThreads = 1u << 10;
constexpr Stamp kSeveralBlocks = 1u << 11;
constexpr int kPhaseShift = 12;
constexpr int kBlockShift = 32;

/// The last accesses of two kinds to four bytes.
struct Shadow {
    Stamp stamps[2];
    std::uint32_t places[2];  ///< offsets of the accesses in the program's text
};
/// The last accesses of all four kinds.
struct SharedShadow {
    Shadow plain;   ///< read, write
    Shadow others;  ///< relaxed read, atomic
};

/// Checkers use it one after the other, because the system takes longer to hand out zeros than a
/// checker to fill them. Stamps of an earlier checker count as those of earlier launches.
class CheckerMemory {
 public:
    /// The size of the simulated device's memory.
    static constexpr std::size_t kDeviceBytes = std::size_t{1} << 32;

    /// Reserves address space, not memory. Throws missing_environment if the system refuses it.
    CheckerMemory();

    std::byte* device() const { return device_.data(); }
    /// By word: read, write.
    Shadow* plain() const { return reinterpret_cast<Shadow*>(plain_.data()); }
    /// By word: relaxed read, atomic.
    Shadow* others() const { return reinterpret_cast<Shadow*>(others_.data()); }
    /// By word: the checker's bits, all 0 when a checker begins.
    std::uint8_t* states() const { return reinterpret_cast<std::uint8_t*>(states_.data()); }

    std::uint32_t next_block = 1;

 private:
    MappedMemory device_;
    MappedMemory plain_;
    MappedMemory others_;
    MappedMemory states_;
};

/// Returns one that was given back, or a new one.
std::unique_ptr<CheckerMemory> take_checker_memory();
/// Its states must all be 0. One is kept for reuse.
void give_back(std::unique_ptr<CheckerMemory> memory);

}  // namespace scotty::emulation::simt
