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
    std::uint32_t ray_count;
    LevelView level;
    HitView hits;
    MinimumView minimum;
    bool strided;
};

/// A ray is done with its first hit where any will do and culling is on.
template <int Width>
void launch_subtrees(const LevelLaunch<Width>& launch, std::uint32_t blocks,
                     std::uint32_t rays_per_block, const FinalHits& final_hits,
                     cudaStream_t stream) {
    if (launch.minimum.culls != 0 && launch.minimum.any_hit != 0) {
        SCOTTY_LAUNCH(intersect_subtrees_any<Width>, blocks, kSubtreeThreads, stream, launch.bvh,
                      launch.rays, launch.ray_count, launch.level, launch.hits, launch.minimum,
                      rays_per_block, launch.strided, final_hits);
    } else {
        SCOTTY_LAUNCH(intersect_subtrees_closest<Width>, blocks, kSubtreeThreads, stream,
                      launch.bvh, launch.rays, launch.ray_count, launch.level, launch.hits,
                      launch.minimum, rays_per_block, launch.strided, final_hits);
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
