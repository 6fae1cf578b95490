/// The arguments of the CUDA kernels: pointers into device memory, and sizes.
#pragma once

#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/subtree_nodes.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

using reference::BatchView;
using reference::FilterView;
using reference::kDone;
using reference::kNoPackedHit;
using reference::PathView;

template <int Width>
struct BvhView {
    /// The inner nodes of the levels with queues, and the roots of the subtrees.
    const reference::WideNode<Width>* inner;
    const reference::Leaf* leaves;
    const TriangleRows* triangles;
    const std::uint32_t* node_refs;
    /// From inner node `first_subtree` on; null if there are none.
    const SubtreeNode<Width>* subtrees = nullptr;
    std::uint32_t first_subtree = 0;
};

/// Faults on the device, read back once per traversal.
struct FaultView {
    std::uint32_t hits_needed;    ///< largest hit count that did not fit, 0: all did
    std::uint32_t queue_needed;   ///< largest queue total that did not fit, 0: all did
    std::uint32_t node_overflow;  ///< node id + 1 of a child whose region was too small
};

struct HitView {
    std::uint32_t packed_mode;
    std::uint32_t capacity;
    std::uint32_t* counts;
    reference::HitCandidate* candidates;
    std::uint64_t* packed;
    FaultView* faults;
};

struct MinimumView {
    std::uint32_t culls;  ///< 0: early-out off
    std::uint32_t any_hit;
    float* minimum;
    float* lowered;  ///< the same array under `immediate`
};

/// The warps of a launch take rays by it.
struct RayTicket {
    std::uint32_t taken;
    std::uint32_t warps_ended;
};

/// The queue of pairs of one level and of the next.
struct PairView {
    const std::uint32_t* count;       ///< entries of this level: at the root, all rays
    const reference::NodeRay* pairs;  ///< null at the root, where entry p is ray p
    std::uint32_t* child_count;
    reference::NodeRay* child_pairs;
    std::uint32_t capacity;  ///< entries that child_pairs has room for
    FaultView* faults;
};

/// One level and the next. Node indices are positions within their level.
struct LevelView {
    std::uint32_t first_node;
    std::uint32_t node_count;
    std::uint32_t first_child_node;
    std::uint32_t child_node_count;
    std::uint32_t queue_capacity;  ///< entries that child_queue has room for
    const std::uint32_t* parents;  ///< by child: the parent's position in this level
    const std::uint32_t* node_counts;
    const std::uint32_t* queue_offsets;
    const std::uint32_t* queue;
    std::uint32_t* block_offsets;
    std::uint32_t* child_counts;
    std::uint32_t* child_offsets;
    std::uint32_t* child_queue;
    // Used by scan_counts, and zero before it.
    std::uint32_t* scan_ticket;
    std::uint64_t* scan_tiles;
    FaultView* faults;
    RayTicket* ray_ticket = nullptr;  ///< used by intersect_subtrees, which leaves it zero
    /// With a queue of pairs, below the root, in place of the queues.
    const reference::NodeRay* pairs = nullptr;
    const std::uint32_t* pair_count = nullptr;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
