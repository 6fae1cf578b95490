/// The binary BVH that the wide one is compacted from. Internal to reference/.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::reference {

/// Node in depth-first order. The left child is the next node; the triangles below a node are
/// order[first .. first + count), so any subtree can be taken as one leaf.
struct BinaryNode {
    Vec3 low, high;       ///< exact bounds of the vertices below, never the builder's
    std::uint32_t first;  ///< into BinaryBvh::order
    std::uint32_t count;
    std::uint32_t right;  ///< index of the right child; kNone at a leaf
};

/// Half of the surface of its box.
inline double half_area(const BinaryNode& node) {
    const double x = double{node.high.x} - double{node.low.x};
    const double y = double{node.high.y} - double{node.low.y};
    const double z = double{node.high.z} - double{node.low.z};
    return x * y + y * z + z * x;
}

struct BinaryBvh {
    std::vector<BinaryNode> nodes;     ///< the root is the first
    std::vector<std::uint32_t> order;  ///< triangle indices of the scene, leaf after leaf
};

/// Down to single triangles (compaction chooses the leaves) by Embree's binned SAH builder
/// (rtcBuildBVH, medium quality, no spatial splits), called in the caller's TBB arena. Its choice
/// of nodes depends neither on threads nor on timing: binning takes only counts, minima and maxima.
/// Where Embree gives up (its depth limit), median splits take over.
/// Requires at least one triangle. Throws missing_environment, internal.
BinaryBvh build_binary_bvh(const Scene& scene);

/// Median splits along the longest axis of the centroids: worse trees, but their depth is
/// logarithmic whatever the input.
BinaryBvh build_median_bvh(const Scene& scene);

}  // namespace scotty::reference
