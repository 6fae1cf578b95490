/// Kernel: level 0. It has one node, whose queue need not exist: ray ids are thread ids.
#pragma once

#include "emulation/kernels/intersect.h"

namespace scotty::emulation {

/// The root is always an inner node (WideBvh), so there is no search and no leaf.
template <int Width>
void intersect_root(const Block& block, const reference::WideBvhView<Width>& bvh,
                    const reference::Ray* rays, std::uint32_t ray_count, const LevelView& level,
                    const MinimumView& minimum) {
    const std::uint32_t first = block.index() * block.threads();
    const BlockWork work{0, first, std::min(block.threads(), ray_count - first)};
    const reference::WideNode<Width> node = bvh.inner[0];
    BlockRays loaded;
    load_rays(block, work, rays, level, minimum, loaded);
    PerThread<std::uint32_t> children;
    test_children(block, work.count, node, loaded, children);
    push_to_children(block, work.count, node, children, loaded, level);
}

}  // namespace scotty::emulation
