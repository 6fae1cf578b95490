/// Kernel: scans a level's queue lengths. Block 0: block offsets; block 1: the children's regions.
#pragma once

#include "gpu/block_scan.h"
#include "gpu/dialect.h"
#include "gpu/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kScanThreads = 1024;

SCOTTY_DEVICE std::uint32_t scan_input(const LevelView& level, bool blocks,
                                       std::uint32_t rays_per_block, std::uint32_t index) {
    if (blocks) return (level.node_counts[index] + rays_per_block - 1) / rays_per_block;
    return level.node_counts[level.parents[index]];
}

SCOTTY_KERNEL(scan_counts)(LevelView level, std::uint32_t rays_per_block) {
    SCOTTY_SHARED(BlockScanShared, shared);
    const bool blocks = block_index() == 0;
    const std::uint32_t count = blocks ? level.node_count : level.child_node_count;
    std::uint32_t* out = blocks ? level.block_offsets : level.child_offsets;
    std::uint32_t carry = 0;
    for (std::uint32_t tile = 0; tile < count; tile += block_size()) {
        const std::uint32_t index = tile + thread_index();
        const std::uint32_t value =
            index < count ? scan_input(level, blocks, rays_per_block, index) : 0;
        const BlockRank rank = SCOTTY_AWAIT(block_exclusive_scan(value, shared));
        if (index < count) out[index] = carry + rank.rank;
        carry += rank.total;
    }
    if (thread_index() == 0) {
        out[count] = carry;
        if (!blocks && carry > level.queue_capacity) {
            atomic_max(&level.faults->queue_needed, carry);
        }
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
