/// Rays that come from elsewhere, traced while nobody watches, against brute force.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/scene.h"
#include "verify/capture/failure.h"
#include "verify/capture/recording.h"

namespace scotty::verify {

/// One hit a ray.
using TraceRays =
    std::function<void(std::span<const reference::Ray> rays, reference::TraversalKind kind,
                       std::span<reference::Hit> hits)>;

struct TraceCheckSettings {
    std::uint64_t seed = 0;      ///< draws the rays
    std::size_t recorded = 160;  ///< rays of the recording, dead ones among them
    std::size_t aimed = 64;      ///< rays at vertices and edges, and along the axes
    /// Ray-triangle tests that brute force may spend; fewer rays are drawn where they would need
    /// more.
    std::uint64_t brute_force_tests = 4'000'000;
    /// Whether an any-hit search says which hit is the closest: it does without an early-out.
    bool any_is_closest = false;
};

/// Rays drawn from all traversals of the recording, dead ones among them; each that hits something
/// once more with an interval that ends or starts at the hit and a unit in the last place beside
/// it; rays at vertices and edges, rays along the axes, and intervals without a point. All of them,
/// in one call, as closest and as any-hit queries. The hits of the closest query have to be brute
/// force's bit for bit, and the recorded ones (`same-unwatched`).
std::vector<Failure> check_traces(const reference::Scene& scene, const Recording& recording,
                                  const TraceRays& trace, const TraceCheckSettings& settings);

}  // namespace scotty::verify
