/// What is known of each four bytes that CUDA threads can share: who touched which of them last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation::cuda {

enum class Access : std::uint8_t {
    none,
    read,
    write,
    volatile_read,
    /// By a thread that has not executed a fence: it announces nothing, and counts as a write.
    volatile_write,
    /// A volatile write after a fence: a flag.
    flag_write,
    atomic_load,
    atomic,  ///< a read and a write in one, or an atomic store
};

/// How many threads a record stands for. Many readers of one word are joined, and their common
/// record then needs more to be ordered before a write than each of them did.
enum class Level : std::uint8_t { lanes, block, grid };

/// Accesses of one kind, by some lanes of a warp between two of its synchronisations.
struct Record {
    Access access = Access::none;
    Level level = Level::lanes;
    std::uint8_t bytes : 4 = 0;  ///< of the word
    bool block_scope : 1 = false;
    std::uint8_t warp = 0;
    std::uint32_t launch = 0;
    std::uint32_t block = 0;
    std::uint32_t lanes = 0;
    std::uint32_t clock = 0;
    std::uint32_t place = 0;  ///< offset of the access in the program's text
    std::uint32_t stack = 0;  ///< of the calls that led there
};

/// The records of a word: two in place, because more are rare.
struct Cell {
    Record first[2];
    std::vector<Record>* more;  ///< owned by the program, null while there are none
};
static_assert(sizeof(Cell) == 64);

enum class RegionKind : std::uint8_t { device, pinned, managed, variable, constant, shared, heap };

/// Memory with a name: an allocation, a variable, an object in shared memory.
struct Region {
    std::byte* begin = nullptr;
    std::size_t bytes = 0;
    RegionKind kind = RegionKind::device;
    bool freed = false;
    bool leak_of_interest = false;  ///< made by cudaMalloc and its like
    std::string name;
    std::uint32_t place = 0;  ///< of its allocation in the program's text; 0: none
    std::uint32_t freed_place = 0;
    Cell* cells = nullptr;              ///< by word
    std::uint8_t* unwritten = nullptr;  ///< a byte for each eight: bits of those nobody has written

    bool holds(const std::byte* at) const { return at >= begin && at < begin + bytes; }
    bool is_unwritten(std::size_t byte) const {
        return unwritten != nullptr && (unwritten[byte / 8] >> byte % 8 & 1u) != 0;
    }
    void set_written(std::size_t from, std::size_t count) const {
        if (unwritten == nullptr) return;
        for (std::size_t byte = from; byte < from + count;) {
            if (byte % 8 == 0 && from + count - byte >= 8) {
                unwritten[byte / 8] = 0;
                byte += 8;
            } else {
                unwritten[byte / 8] &= static_cast<std::uint8_t>(~(1u << byte % 8));
                ++byte;
            }
        }
    }
};

}  // namespace scotty::emulation::cuda
