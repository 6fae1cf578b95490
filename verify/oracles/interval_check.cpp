#include "verify/oracles/interval_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "reference/base/error.h"
#include "reference/truth/tracers.h"
#include "verify/base/same_bits.h"

namespace scotty::verify {

using reference::Hit;
using reference::Ray;

namespace {

constexpr std::size_t kMostRays = 256;

/// The rays that hit something, with the distance.
std::vector<std::pair<Ray, float>> rays_with_hits(const Recording& recording, std::size_t most) {
    std::vector<std::pair<Ray, float>> found;
    for (const TraversalRecord& traversal : recording.traversals) {
        if (traversal.is_shadow()) continue;
        for (std::size_t i = 0; i < traversal.rays.size() && found.size() < most; ++i) {
            if (is_dead(traversal.rays[i]) || !is_hit(traversal.hits[i])) continue;
            found.emplace_back(traversal.rays[i], traversal.hits[i].t);
        }
    }
    return found;
}

void compare(const reference::Scene& scene, const std::vector<Ray>& rays, const char* sentence,
             const TraceClosest& trace, std::vector<Failure>& failures) {
    Failure failure;
    failure.invariant = "brute-force";
    failure.stage = "trace";
    failure.field = "hit";
    std::vector<Hit> hits(rays.size());
    std::vector<Hit> truth(rays.size());
    try {
        trace(rays, hits);
    } catch (const reference::Error& error) {
        failure.sentence = error.what();
        failures.push_back(std::move(failure));
        return;
    }
    reference::brute_force_closest(scene, rays, truth);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (same_bits(hits[i], truth[i])) continue;
        failure.ray = static_cast<std::uint32_t>(i);
        failure.sentence = fmt::format("{}; the ray: {}", sentence, exact(rays[i]));
        failure.expected = exact(truth[i]);
        failure.found = exact(hits[i]);
        failures.push_back(std::move(failure));
        return;
    }
}

}  // namespace

std::vector<Failure> check_intervals(const reference::Scene& scene, const Recording& recording,
                                     const TraceClosest& trace, std::uint64_t tests) {
    const std::uint64_t triangles = std::max<std::uint64_t>(1, scene.triangles.size());
    const auto most =
        static_cast<std::size_t>(std::min<std::uint64_t>(kMostRays, tests / (2 * triangles)));
    std::vector<Ray> ending;
    std::vector<Ray> starting;
    for (const auto& [ray, t] : rays_with_hits(recording, most)) {
        ending.push_back(ray);
        ending.back().t_max = t;
        starting.push_back(ray);
        starting.back().t_min = t;
    }
    std::vector<Failure> failures;
    if (ending.empty()) return failures;
    compare(scene, ending, "a ray that ends where it hit something does not hit it", trace,
            failures);
    compare(scene, starting, "a ray that starts where it hit something hits it", trace, failures);
    return failures;
}

}  // namespace scotty::verify
