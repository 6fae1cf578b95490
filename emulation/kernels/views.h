/// The arguments of kernels: plain pointers into device buffers, and sizes.
#pragma once

#include <cstdint>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/views.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

using reference::BatchView;
using reference::FilterView;
using reference::kDone;
using reference::kNoPackedHit;
using reference::PathView;

/// The hits that a traversal gathers, by ray id.
struct HitView {
    reference::HitMode mode;
    std::uint32_t capacity;               ///< slots per ray in the multi-intersection buffer
    std::uint32_t* counts;                ///< buffer mode: hits so far, may exceed the capacity
    reference::HitCandidate* candidates;  ///< buffer mode: [ray * capacity + slot]
    std::uint64_t* packed;                ///< packed mode: t bits << 32 | primitive
    std::uint32_t* needed;                ///< the largest count that did not fit, 0 if all did
};

/// The nearest distance known, by ray id.
struct MinimumView {
    reference::EarlyOut policy;
    bool any_hit;    ///< the traversal asks only whether something is hit
    float* minimum;  ///< the values that kernels cull by
    float* lowered;  ///< the values that they lower: the same array under `immediate`
};

/// The queues of one level and of the next. Node indices are positions within their level.
struct LevelView {
    std::uint32_t first_node;  ///< node id of this level's first node
    std::uint32_t node_count;
    std::uint32_t first_child_node;      ///< node id of the next level's first node
    const std::uint32_t* node_counts;    ///< entries in each node's queue
    const std::uint32_t* queue_offsets;  ///< where each node's queue begins
    const std::uint32_t* queue;          ///< ray ids; null at the root, whose queue is 0..n-1
    const std::uint32_t* block_offsets;  ///< [node_count + 1], exclusive scan of blocks per node
    std::uint32_t* child_counts;         ///< of the next level's nodes
    const std::uint32_t* child_offsets;  ///< [children + 1]: each child's region of child_queue
    std::uint32_t* child_queue;
    std::uint32_t* overflow;  ///< node id + 1 of a child whose region was too small
};

}  // namespace scotty::emulation
