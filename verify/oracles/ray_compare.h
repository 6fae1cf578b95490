/// Compares hits of rays from a file with another tracer's.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "reference/truth/tracers.h"
#include "verify/capture/ray_file.h"

namespace scotty::verify {

/// A ray on which the two disagree.
struct HitMismatch {
    std::uint32_t ray = 0;
    reference::HitCandidate ours, theirs;
    reference::Adjudication verdict;
};

struct HitComparison {
    bool any_hit = false;
    std::uint64_t rays = 0;
    std::uint64_t agree = 0;
    double largest_gap = 0.0;  ///< of t, relative, if both hit the same primitive
    std::uint64_t ties = 0;
    std::uint64_t grazing = 0;
    std::uint64_t theirs_wrong = 0;
    std::uint64_t ours_wrong = 0;
    std::vector<HitMismatch> mismatches;  ///< at most 20; those where we are wrong come first

    bool passed() const { return ours_wrong == 0; }
};

/// Agreement is the same primitive (or the same answer), or a difference that double precision
/// excuses. Both lists are as hit_record() makes them, one per ray. A distance that is off by more
/// than rounding is adjudicated although the primitive is the same.
HitComparison compare_hits(const reference::Scene& scene, const RayFile& rays,
                           std::span<const reference::HitCandidate> ours,
                           std::span<const reference::HitCandidate> theirs);

std::string to_text(const HitComparison& comparison);

}  // namespace scotty::verify
