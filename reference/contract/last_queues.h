/// In which node's queue the rays wait that a triangle is tested against.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/contract/wide_bvh.h"

namespace scotty::reference {

/// By primitive: the id of its leaf, or where the leaf is below the levels that have queues
/// (cut_levels()) the id of the subtree's root. kNone for a primitive that no leaf holds.
std::vector<std::uint32_t> last_queues(const WideBvh& bvh);

}  // namespace scotty::reference
