/// Exclusive scan over the threads of a block: shuffles in the warp, one pass over the warps' sums.
#pragma once

#include "gpu/kernels/dialect.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kMaxWarps = 32;

struct BlockScanShared {
    std::uint32_t warp_sums[kMaxWarps];
    std::uint32_t total;
};

struct BlockRank {
    std::uint32_t rank;   ///< sum of the values of all threads before this one
    std::uint32_t total;  ///< of the whole block
};

/// All threads of the block take part; it ends with a barrier, so `shared` can be used again.
SCOTTY_COLLECTIVE(BlockRank) block_exclusive_scan(std::uint32_t value, BlockScanShared& shared) {
    std::uint32_t inclusive = value;
    for (std::uint32_t delta = 1; delta < kWarpSize; delta *= 2) {
        const std::uint32_t below = SCOTTY_AWAIT(warp_shuffle_up(inclusive, delta));
        if (lane_index() >= delta) inclusive += below;
    }
    if (lane_index() == kWarpSize - 1) shared.warp_sums[warp_index()] = inclusive;
    SCOTTY_SYNC();
    const std::uint32_t warps = block_size() / kWarpSize;
    if (warp_index() == 0) {
        const std::uint32_t own = lane_index() < warps ? shared.warp_sums[lane_index()] : 0;
        std::uint32_t sums = own;
        for (std::uint32_t delta = 1; delta < kWarpSize; delta *= 2) {
            const std::uint32_t below = SCOTTY_AWAIT(warp_shuffle_up(sums, delta));
            if (lane_index() >= delta) sums += below;
        }
        if (lane_index() < warps) shared.warp_sums[lane_index()] = sums - own;
        if (lane_index() == kWarpSize - 1) shared.total = sums;
    }
    SCOTTY_SYNC();
    const BlockRank result{shared.warp_sums[warp_index()] + inclusive - value, shared.total};
    SCOTTY_SYNC();
    SCOTTY_RETURN result;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
