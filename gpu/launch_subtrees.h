/// Which kernel takes the last level that has queues.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "gpu/dialect.h"
#include "gpu/intersect_subtrees.h"
#include "gpu/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// What a launch of one level is about.
template <int Width>
struct LevelLaunch {
    BvhView<Width> bvh;
    const reference::Ray* rays;
    LevelView level;
    HitView hits;
    MinimumView minimum;
    bool strided;
};

/// Whether a ray is done with its first hit.
inline bool ends_with_any_hit(const MinimumView& minimum) {
    return minimum.culls != 0 && minimum.any_hit != 0;
}
/// Threads a block of the launch, and rays that it takes at once.
inline std::uint32_t subtree_threads(const MinimumView& minimum, std::uint32_t rays_per_block) {
    return ends_with_any_hit(minimum) ? rays_per_block : kPoolRays;
}

template <int Width>
void launch_subtrees(const LevelLaunch<Width>& launch, std::uint32_t blocks,
                     std::uint32_t rays_per_block, const FinalHits& final_hits,
                     cudaStream_t stream) {
    const std::uint32_t threads = subtree_threads(launch.minimum, rays_per_block);
    if (ends_with_any_hit(launch.minimum)) {
        SCOTTY_LAUNCH(intersect_subtrees_any<Width>, blocks, threads, stream, launch.bvh,
                      launch.rays, launch.level, launch.hits, launch.minimum, launch.strided,
                      final_hits);
    } else {
        SCOTTY_LAUNCH(intersect_subtrees_closest<Width>, blocks, threads, stream, launch.bvh,
                      launch.rays, launch.level, launch.hits, launch.minimum, rays_per_block,
                      launch.strided, final_hits);
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
