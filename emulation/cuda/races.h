/// Finds pairs of accesses that nothing orders, whatever came of them.
///
/// Two accesses to one byte conflict where one of them is a plain write, or one is plain and the
/// other atomic, or both are atomic and the scope of one does not reach the other. They are ordered
/// by a barrier of the block, by __syncwarp, and by what passes through atomics and fences.
#pragma once

#include <cstdint>

#include "emulation/cuda/shadow.h"
#include "emulation/cuda/threads.h"

namespace scotty::emulation::cuda {

/// One access of the running thread.
struct Touch {
    Access access = Access::read;
    bool block_scope = false;  ///< an atomic of the block's scope
    std::uint32_t launch = 0;
    std::uint32_t place = 0;
    std::uint32_t stack = 0;
    std::uint32_t blocks = 0;  ///< of the grid
};

/// Looks for a record of the word that conflicts with the access to some of its bytes and that
/// nothing orders before it; then records the access. Returns whether there was one, in `other`.
bool find_race(Cell& cell, unsigned bytes, const Touch& touch, const Thread& thread, Record& other);

/// All of the word's records are gone.
void clear(Cell& cell);

}  // namespace scotty::emulation::cuda
