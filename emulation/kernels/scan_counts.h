/// Kernel: one block scans a level's queue lengths into block offsets and the children's regions.
///
/// "Limited blocks": a node gets ceil(count / rays per block) blocks, not the worst case's number.
/// A child's region is as long as its parent's queue, which no push can exceed.
#pragma once

#include <cstdint>

#include "emulation/device/device.h"

namespace scotty::emulation {

constexpr std::uint32_t kScanThreads = 256;

struct ScanView {
    std::uint32_t node_count;
    const std::uint32_t* node_counts;
    std::uint32_t child_count;           ///< nodes of the next level
    const std::uint32_t* child_parents;  ///< by child: parent's position in this level
    std::uint32_t rays_per_block;
    std::uint32_t* block_offsets;  ///< out, [node_count + 1]
    std::uint32_t* child_offsets;  ///< out, [child_count + 1]
};

/// Exclusive scan of value(0..n-1) into out[0..n], the total last. Every thread sums a strip, the
/// strips' sums are scanned, every thread writes its strip.
template <class Value>
void block_exclusive_scan(const Block& block, std::uint32_t n, const Value& value,
                          std::uint32_t* out) {
    Shared<std::uint32_t> strip_sum("strip_sum");
    const std::uint32_t strip = (n + block.threads() - 1) / block.threads();
    const auto strip_begin = [&](std::uint32_t thread) { return std::min(n, thread * strip); };
    block.phase([&](std::uint32_t thread) {
        std::uint32_t sum = 0;
        for (std::uint32_t i = strip_begin(thread); i < strip_begin(thread + 1); ++i) {
            sum += value(i);
        }
        strip_sum[thread] = sum;
    });
    block.phase_thread_zero([&] {
        std::uint32_t sum = 0;
        for (std::uint32_t thread = 0; thread < block.threads(); ++thread) {
            const std::uint32_t own = strip_sum[thread];
            strip_sum[thread] = sum;
            sum += own;
        }
        out[n] = sum;
    });
    block.phase([&](std::uint32_t thread) {
        std::uint32_t sum = strip_sum[thread];
        for (std::uint32_t i = strip_begin(thread); i < strip_begin(thread + 1); ++i) {
            out[i] = sum;
            sum += value(i);
        }
    });
}

inline void scan_counts(const Block& block, const ScanView& scan) {
    block_exclusive_scan(
        block, scan.node_count,
        [&](std::uint32_t node) {
            return (scan.node_counts[node] + scan.rays_per_block - 1) / scan.rays_per_block;
        },
        scan.block_offsets);
    block_exclusive_scan(
        block, scan.child_count,
        [&](std::uint32_t child) { return scan.node_counts[scan.child_parents[child]]; },
        scan.child_offsets);
}

}  // namespace scotty::emulation
