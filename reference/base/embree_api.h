/// Embree 3 or 4: the one file that knows the difference.
///
/// Only .cpp files include it, so that nothing else depends on Embree's types.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <memory>
#include <string>
#include <type_traits>

#include "reference/base/error.h"

namespace scotty::reference {

struct ReleaseEmbree {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
    void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};
/// Owner of one reference to an Embree object.
template <typename Handle>
using EmbreeOwner = std::unique_ptr<std::remove_pointer_t<Handle>, ReleaseEmbree>;

/// Throws missing_environment when Embree cannot start.
///
/// TBB keeps the floating-point control word that a thread has when it first meets TBB and hands it
/// to all later tasks. Embree sets flush-to-zero while it builds, so that it must not be the first:
/// every kernel that the emulator ran afterwards would flush denormals.
inline EmbreeOwner<RTCDevice> make_embree_device() {
    tbb::parallel_for(0, 2, [](int) {});
    EmbreeOwner<RTCDevice> device(rtcNewDevice(nullptr));
    if (!device) {
        throw Error::missing_environment(fmt::format("Embree {} cannot start (error {})",
                                                     RTC_VERSION_STRING,
                                                     static_cast<int>(rtcGetDeviceError(nullptr))));
    }
    return device;
}

/// Throws internal, naming the call, where Embree has reported an error since it was last asked.
inline void check_embree(RTCDevice device, const std::string& call) {
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) {
        throw Error::internal(fmt::format("Embree {}: {} failed with error {}", RTC_VERSION_STRING,
                                          call, static_cast<int>(error)));
    }
}

#if RTC_VERSION_MAJOR >= 4

inline void embree_intersect(RTCScene scene, RTCRayHit& ray_hit) {
    rtcIntersect1(scene, &ray_hit, nullptr);
}
inline void embree_occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }

#else

inline void embree_intersect(RTCScene scene, RTCRayHit& ray_hit) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray_hit);
}
inline void embree_occluded(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
}

#endif

}  // namespace scotty::reference
