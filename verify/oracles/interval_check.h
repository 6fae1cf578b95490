/// Hits count in [t_min, t_max). Rays of a render hardly ever end or start exactly at a surface, so
/// this traces some that do.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "reference/contract/scene.h"
#include "verify/capture/failure.h"
#include "verify/capture/recording.h"

namespace scotty::verify {

/// Traces closest hits, one per ray.
using TraceClosest =
    std::function<void(std::span<const reference::Ray> rays, std::span<reference::Hit> hits)>;

/// Takes the first rays of the recording that hit something and cuts each twice: to end at the hit,
/// which then does not count, and to start there, where it does. Brute force must agree bit for
/// bit; at most one failure for each cut. `tests`: ray-triangle tests that brute force may spend.
std::vector<Failure> check_intervals(const reference::Scene& scene, const Recording& recording,
                                     const TraceClosest& trace, std::uint64_t tests);

}  // namespace scotty::verify
