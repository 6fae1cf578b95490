/// Kernel: scans a level's queue lengths into block offsets and the children's regions.
///
/// One pass over tiles of one block each (decoupled look-back: Merrill and Garland 2016,
/// "Single-pass Parallel Prefix Scan"). A tile publishes its own sum, adds the sums published by
/// the tiles before it, and publishes the total. The nodes' tiles come first, then the children's.
#pragma once

#include "gpu/kernels/block_scan.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/base/host_device.h"

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kScanThreads = 1024;  ///< and elements of a tile

/// The state that a tile has published stands above its 32-bit sum, in one word, so that whoever
/// sees one sees the other. Zero: nothing yet.
constexpr std::uint64_t kOwnSum = std::uint64_t{1} << 32;    ///< of the tile alone
constexpr std::uint64_t kWholeSum = std::uint64_t{2} << 32;  ///< of all tiles up to it

struct ScanShared {
    BlockScanShared threads;
    std::uint32_t tile;
    std::uint32_t before;  ///< sum of the tiles before
};

/// Every scan has a tile, if only to write a total of zero.
SCOTTY_HD std::uint32_t scan_tiles(std::uint32_t count) {
    return count == 0 ? 1 : (count + kScanThreads - 1) / kScanThreads;
}
/// Blocks of a launch, and words at LevelView::scan_tiles.
SCOTTY_HD std::uint32_t scan_blocks(std::uint32_t nodes, std::uint32_t children) {
    return scan_tiles(nodes) + scan_tiles(children);
}

SCOTTY_DEVICE std::uint32_t scan_input(const LevelView& level, bool blocks,
                                       std::uint32_t rays_per_block, std::uint32_t index) {
    if (blocks) return (level.node_counts[index] + rays_per_block - 1) / rays_per_block;
    return level.node_counts[level.parents[index]];
}

/// Sum of all tiles before one, by one warp, 32 tiles at a time, from the nearest back to the first
/// that knows the sum of all before it.
SCOTTY_COLLECTIVE(std::uint32_t) sum_before(const std::uint64_t* tiles, std::uint32_t tile) {
    std::uint32_t sum = 0;
    for (std::uint32_t end = tile;; end -= kWarpSize) {
        const bool there = lane_index() < end;
        // Before the first tile the sum is zero, and whole.
        std::uint64_t published = there ? load_relaxed(tiles + end - 1 - lane_index()) : kWholeSum;
        while (SCOTTY_AWAIT(warp_any(published == 0))) {
            if (published == 0) published = load_relaxed(tiles + end - 1 - lane_index());
        }
        const std::uint32_t whole = SCOTTY_AWAIT(warp_ballot(published >= kWholeSum));
        // These are the lanes up to the nearest whole sum.
        const bool counts = bits_below_lane(whole) == 0;
        std::uint32_t value = counts ? static_cast<std::uint32_t>(published) : 0;
        for (std::uint32_t apart = kWarpSize / 2; apart != 0; apart /= 2) {
            value += SCOTTY_AWAIT(warp_shuffle(value, lane_index() ^ apart));
        }
        sum += value;
        if (whole != 0) break;
    }
    SCOTTY_RETURN sum;
}

SCOTTY_KERNEL(scan_counts)(LevelView level, std::uint32_t rays_per_block) {
    SCOTTY_SHARED(ScanShared, shared);
    // Tiles are taken in the order in which blocks start, so that the blocks that one waits for are
    // running.
    if (thread_index() == 0) shared.tile = atomic_add(level.scan_ticket, 1);
    SCOTTY_SYNC();
    const std::uint32_t node_tiles = scan_tiles(level.node_count);
    const bool blocks = shared.tile < node_tiles;
    const std::uint32_t tile = blocks ? shared.tile : shared.tile - node_tiles;
    const std::uint32_t count = blocks ? level.node_count : level.child_node_count;
    std::uint64_t* tiles = level.scan_tiles + (blocks ? 0 : node_tiles);
    std::uint32_t* out = blocks ? level.block_offsets : level.child_offsets;

    const std::uint32_t index = tile * block_size() + thread_index();
    // After an overflow queues are shorter than their counts say, so levels get no more blocks.
    const bool counts = !blocks || level.faults->node_overflow == 0;
    const std::uint32_t value =
        index < count && counts ? scan_input(level, blocks, rays_per_block, index) : 0;
    const BlockRank rank = SCOTTY_AWAIT(block_exclusive_scan(value, shared.threads));
    if (warp_index() == 0) {
        std::uint32_t before = 0;
        if (tile != 0) {
            if (lane_index() == 0) store_relaxed(tiles + tile, kOwnSum | rank.total);
            before = SCOTTY_AWAIT(sum_before(tiles, tile));
        }
        if (lane_index() == 0) {
            store_relaxed(tiles + tile, kWholeSum | (before + rank.total));
            shared.before = before;
        }
    }
    SCOTTY_SYNC();
    const std::uint32_t before = shared.before;
    if (index < count) out[index] = before + rank.rank;
    if (thread_index() == 0 && tile == scan_tiles(count) - 1) {
        const std::uint32_t total = before + rank.total;
        out[count] = total;
        if (!blocks && total > level.queue_capacity) {
            atomic_max(&level.faults->queue_needed, total);
        }
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
