/// Which kernel takes the last level that has queues, and how many blocks of it.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect_pairs.h"
#include "gpu/kernels/intersect_subtrees.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// What a launch of one level is about.
template <int Width>
struct LevelLaunch {
    BvhView<Width> bvh;
    const reference::Ray* rays;
    LevelView level;
    HitView hits;
    MinimumView minimum;
};

/// `resident`: blocks that the device holds at once. A ray is done with its first hit where any
/// will do and culling is on. A level without queues is level 0.
template <int Width>
void launch_subtrees(const LevelLaunch<Width>& launch, std::uint32_t resident, SubtreeWork work,
                     const FinalHits& final_hits, cudaStream_t stream) {
    std::uint32_t blocks = resident;
    if (launch.level.queue == nullptr) {
        const std::uint32_t enough = (work.ray_count + kSubtreeThreads - 1) / kSubtreeThreads;
        blocks = work.coherent ? enough : std::min(enough, resident);
    } else {
        work.coherent = false;
    }
    if (blocks == 0) return;
    if (launch.minimum.culls != 0 && launch.minimum.any_hit != 0) {
        SCOTTY_LAUNCH(intersect_subtrees_any<Width>, blocks, kSubtreeThreads, stream, launch.bvh,
                      launch.rays, launch.level, launch.hits, launch.minimum, work, final_hits);
    } else {
        SCOTTY_LAUNCH(intersect_subtrees_closest<Width>, blocks, kSubtreeThreads, stream,
                      launch.bvh, launch.rays, launch.level, launch.hits, launch.minimum, work,
                      final_hits);
    }
}

/// The same from a queue of pairs: `work` need not say how many there are.
template <int Width>
void launch_pair_subtrees(const LevelLaunch<Width>& launch, std::uint32_t resident,
                          const SubtreeWork& work, cudaStream_t stream) {
    if (launch.minimum.culls != 0 && launch.minimum.any_hit != 0) {
        SCOTTY_LAUNCH(intersect_pair_subtrees_any<Width>, resident, kSubtreeThreads, stream,
                      launch.bvh, launch.rays, launch.level, launch.hits, launch.minimum, work,
                      FinalHits{});
    } else {
        SCOTTY_LAUNCH(intersect_pair_subtrees_closest<Width>, resident, kSubtreeThreads, stream,
                      launch.bvh, launch.rays, launch.level, launch.hits, launch.minimum, work,
                      FinalHits{});
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
