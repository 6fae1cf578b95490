/// Hits count in [t_min, t_max): rays of a render hardly ever end or start just where something is,
/// so some are traced that do.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "reference/contract/scene.h"
#include "verify/capture/failure.h"
#include "verify/capture/recording.h"

namespace scotty::verify {

/// Traces closest hits: one a ray.
using TraceClosest =
    std::function<void(std::span<const reference::Ray> rays, std::span<reference::Hit> hits)>;

/// The first rays of the recording that hit something, cut twice: to end at the hit, which then
/// does not count, and to start there, where it does. Held against brute force bit for bit; at most
/// one failure for each of the two. `tests`: ray-triangle tests that brute force may spend.
std::vector<Failure> check_intervals(const reference::Scene& scene, const Recording& recording,
                                     const TraceClosest& trace, std::uint64_t tests);

}  // namespace scotty::verify
