/// The pretended device's memory, and what is known of each of its words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "emulation/check/mapped_memory.h"

namespace scotty::emulation::simt {

/// Who touched a word: its block in the upper half, counted over all launches and from 1, so that
/// what is less than the launch's first is of an earlier launch; in the lower half
/// phase << 12 | several blocks | several threads | thread. 0: nobody.
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
/// Those of all kinds.
struct SharedShadow {
    Shadow plain;   ///< read, write
    Shadow others;  ///< relaxed read, atomic
};

/// Of one checker after the other: the system takes longer to hand out zeros than a checker to fill
/// them. What an earlier checker has stamped is of earlier launches.
class CheckerMemory {
 public:
    /// What the pretended device has.
    static constexpr std::size_t kDeviceBytes = std::size_t{1} << 32;

    /// Address space set aside, not memory used. Throws missing_environment where the system
    /// refuses it.
    CheckerMemory();

    std::byte* device() const { return device_.data(); }
    /// By word: read, write.
    Shadow* plain() const { return reinterpret_cast<Shadow*>(plain_.data()); }
    /// By word: relaxed read, atomic.
    Shadow* others() const { return reinterpret_cast<Shadow*>(others_.data()); }
    /// By word: bits of the checker's; all 0 when one begins.
    std::uint8_t* states() const { return reinterpret_cast<std::uint8_t*>(states_.data()); }

    std::uint32_t next_block = 1;

 private:
    MappedMemory device_;
    MappedMemory plain_;
    MappedMemory others_;
    MappedMemory states_;
};

/// One that was given back, or a new one.
std::unique_ptr<CheckerMemory> take_checker_memory();
/// With all states 0. One is kept.
void give_back(std::unique_ptr<CheckerMemory> memory);

}  // namespace scotty::emulation::simt
