/// Moves subtrees of a binary BVH to where they cost less. Internal to reference/.
///
/// Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", Computer
/// Graphics Forum 37 (2), 2018. Two things differ. Moves found in parallel do not lock nodes: they
/// are made one after the other, the best first, and each only where it still pays in the tree as
/// it is by then. So the cost never rises, and the result does not depend on threads or timing. And
/// of a large tree only the nodes of the largest boxes are tried, which is nearly all of the gain.
///
/// Subtrees are moved as they are, and no triangle is split. A subtree, or a scene, whose areas
/// vanish in single precision stays as it was.
#pragma once

#include "reference/bvh/binary_bvh.h"

namespace scotty::reference {

/// Expected inner nodes that a line through the root's box enters: the sum of their areas as a
/// share of the root's (the surface-area heuristic). 0 where the root has no area.
double surface_area_cost(const BinaryBvh& bvh);

/// Lowers surface_area_cost(), in the caller's TBB arena; the order of nodes is depth first again,
/// boxes are the exact unions of their children's. Requires leaves of one triangle each, as
/// build_binary_bvh() makes them.
void optimise_by_reinsertion(BinaryBvh& bvh);

}  // namespace scotty::reference
