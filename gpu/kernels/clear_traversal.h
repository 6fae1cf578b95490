/// Kernel: the state in which a traversal starts: all rays at the root, everything else zero.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(clear_traversal)
(std::uint32_t rays, std::uint32_t nodes, std::uint32_t* node_counts, std::uint32_t scans,
 std::uint64_t* scan_words, FaultView* faults) {
    const std::uint32_t i = block_index() * block_size() + thread_index();
    if (i >= nodes && i >= scans) SCOTTY_RETURN;
    if (i == 0) *faults = FaultView{};
    if (i < nodes) node_counts[i] = i == 0 ? rays : 0;
    if (i < scans) scan_words[i] = 0;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
