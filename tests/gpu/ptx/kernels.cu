/// Every kernel, for every width: compiled to PTX to see which instructions they become.
#include <cuda_runtime.h>

#include "gpu/kernels/clear_traversal.h"
#include "gpu/kernels/direct_light_rays.h"
#include "gpu/kernels/filter_image.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/intersect_root.h"
#include "gpu/kernels/intersect_subtrees.h"
#include "gpu/kernels/merge_intersections.h"
#include "gpu/kernels/primary_rays.h"
#include "gpu/kernels/publish_minimum.h"
#include "gpu/kernels/reconstruct_image.h"
#include "gpu/kernels/resolve_light.h"
#include "gpu/kernels/scan_counts.h"
#include "gpu/kernels/scene_rays.h"

namespace SCOTTY_DEVICE_NAMESPACE {

template __global__ void intersect<2>(BvhView<2>, const reference::Ray*, LevelView, HitView,
                                      MinimumView, bool);
template __global__ void intersect<4>(BvhView<4>, const reference::Ray*, LevelView, HitView,
                                      MinimumView, bool);
template __global__ void intersect<8>(BvhView<8>, const reference::Ray*, LevelView, HitView,
                                      MinimumView, bool);
template __global__ void intersect<16>(BvhView<16>, const reference::Ray*, LevelView, HitView,
                                       MinimumView, bool);
template __global__ void intersect_root<2>(BvhView<2>, const reference::Ray*, std::uint32_t,
                                           LevelView, HitView, MinimumView);
template __global__ void intersect_subtrees_any<2>(BvhView<2>, const reference::Ray*, LevelView,
                                                   HitView, MinimumView, SubtreeWork, FinalHits);
template __global__ void intersect_subtrees_closest<2>(BvhView<2>, const reference::Ray*, LevelView,
                                                       HitView, MinimumView, SubtreeWork,
                                                       FinalHits);

template __global__ void intersect_root<4>(BvhView<4>, const reference::Ray*, std::uint32_t,
                                           LevelView, HitView, MinimumView);
template __global__ void intersect_subtrees_any<4>(BvhView<4>, const reference::Ray*, LevelView,
                                                   HitView, MinimumView, SubtreeWork, FinalHits);
template __global__ void intersect_subtrees_closest<4>(BvhView<4>, const reference::Ray*, LevelView,
                                                       HitView, MinimumView, SubtreeWork,
                                                       FinalHits);

template __global__ void intersect_root<8>(BvhView<8>, const reference::Ray*, std::uint32_t,
                                           LevelView, HitView, MinimumView);
template __global__ void intersect_subtrees_any<8>(BvhView<8>, const reference::Ray*, LevelView,
                                                   HitView, MinimumView, SubtreeWork, FinalHits);
template __global__ void intersect_subtrees_closest<8>(BvhView<8>, const reference::Ray*, LevelView,
                                                       HitView, MinimumView, SubtreeWork,
                                                       FinalHits);

template __global__ void intersect_root<16>(BvhView<16>, const reference::Ray*, std::uint32_t,
                                            LevelView, HitView, MinimumView);
template __global__ void intersect_subtrees_any<16>(BvhView<16>, const reference::Ray*, LevelView,
                                                    HitView, MinimumView, SubtreeWork, FinalHits);
template __global__ void intersect_subtrees_closest<16>(BvhView<16>, const reference::Ray*,
                                                        LevelView, HitView, MinimumView,
                                                        SubtreeWork, FinalHits);

}  // namespace SCOTTY_DEVICE_NAMESPACE
