/// Recorded hits against two independent truths: brute force and Embree.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "reference/truth/tracers.h"
#include "verify/capture/failure.h"
#include "verify/capture/recording.h"

namespace scotty::verify {

struct HitCheckSettings {
    /// Ray-triangle tests that brute force may spend on a scene; if all rays would need more, it
    /// checks a subset drawn by `seed`.
    std::uint64_t brute_force_tests = 400'000'000;
    std::uint64_t seed = 0;
    std::string stage_pattern;  ///< only traversals whose merge stage matches
};

struct HitCheckResult {
    std::uint64_t traversals = 0;
    std::uint64_t rays = 0;              ///< living rays of all traversals
    std::uint64_t brute_force_rays = 0;  ///< of those, the rays that brute force has traced
    std::uint64_t embree_rays = 0;       ///< closest-hit queries
    std::uint64_t occlusion_rays = 0;    ///< any-hit queries
    std::uint64_t ties = 0;
    std::uint64_t grazing = 0;
    std::uint64_t embree_wrong = 0;
    std::uint64_t ours_wrong = 0;
    /// By path: a hit on which we and Embree differ for a reason. After it the two pictures may
    /// differ.
    std::vector<bool> excused;
    std::vector<Failure> failures;  ///< at most 20; the first leads

    /// Numbers and failures of both; paths of two runs have nothing to do with each other.
    HitCheckResult& operator+=(const HitCheckResult& other);
};

/// Brute force: hits are equal bit for bit. Embree: the same primitive, or an adjudicated
/// difference that is not our error; for shadow rays also the any-hit answer.
HitCheckResult check_hits(const reference::Scene& scene, const Recording& recording,
                          const reference::EmbreeTracer& embree, std::uint32_t spp,
                          const HitCheckSettings& settings);

struct ImageCheckResult {
    std::uint64_t pixels = 0;
    std::uint64_t identical = 0;
    std::uint64_t excused = 0;  ///< different, with an excused path in the pixel
    std::vector<Failure> failures;

    ImageCheckResult& operator+=(const ImageCheckResult& other);
};

/// Compares pixels bit for bit, except those of an excused path.
ImageCheckResult check_image(const reference::Image& ours, const reference::Image& embree,
                             const std::vector<bool>& excused, std::uint32_t spp);

}  // namespace scotty::verify
