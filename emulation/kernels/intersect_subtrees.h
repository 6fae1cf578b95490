/// Kernel: the last level that has queues, if the tree goes on below it. Each ray goes on from its
/// node alone, depth-first. Leaves of the level are treated as on every level.
#pragma once

#include "emulation/kernels/intersect.h"
#include "reference/numerics/closest_in_subtree.h"

namespace scotty::emulation {

template <int Width>
void intersect_subtrees(const Block& block, const reference::WideBvhView<Width>& bvh,
                        const reference::Ray* rays, const LevelView& level, const HitView& hits,
                        const MinimumView& minimum, std::uint32_t grid_side) {
    const bool any = minimum.policy != reference::EarlyOut::off && minimum.any_hit;
    visit_queue(block, bvh, rays, level, hits, minimum, grid_side,
                [&](std::uint32_t inner, const BlockWork& work, const BlockRays& loaded) {
                    block.phase(work.count, [&](std::uint32_t thread) {
                        const reference::HitCandidate best =
                            reference::closest_in_subtree(bvh, inner, rays[loaded.id[thread]],
                                                          loaded.limit[thread], any)
                                .best;
                        if (best.primitive != reference::kNone) {
                            record_hit(loaded.id[thread], best, hits, minimum);
                        }
                    });
                });
}

}  // namespace scotty::emulation
