#include "verify/oracles/ray_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "reference/base/assert.h"
#include "reference/truth/ray_triangle_double.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

using reference::Disagreement;
using reference::Hit;
using reference::HitCandidate;

namespace {

constexpr std::size_t kKept = 20;
/// The relative gap of t above which the same primitive does not count as agreement: the rounding
/// of two tracers is a thousand times smaller, except for grazing rays, which adjudication excuses.
constexpr double kDistanceGap = 1e-4;

/// Such files hold no barycentrics; adjudication gets those of the primitive, so that it judges
/// primitive and distance.
Hit hit_of(const reference::Scene& scene, const reference::Ray& ray, const HitCandidate& record) {
    Hit hit{record.t, record.primitive, 0.0f, 0.0f};
    if (record.primitive < scene.triangles.size()) {
        const reference::TriangleVerdict truth =
            reference::judge_triangle(scene, record.primitive, ray);
        hit.u = static_cast<float>(truth.u);
        hit.v = static_cast<float>(truth.v);
    }
    return hit;
}

double relative_gap(const HitCandidate& a, const HitCandidate& b) {
    if (a.t == b.t) return 0.0;
    const double scale = std::max(std::abs(double{a.t}), std::abs(double{b.t}));
    return std::abs(double{a.t} - double{b.t}) / scale;
}

std::string text_of(const HitCandidate& record, bool any_hit) {
    if (any_hit) return record.primitive != 0 ? "occluded" : "free";
    if (record.primitive == reference::kNone) return "no hit";
    return fmt::format("primitive {} at t {}", record.primitive, exact(record.t));
}

}  // namespace

HitComparison compare_hits(const reference::Scene& scene, const RayFile& rays,
                           std::span<const HitCandidate> ours,
                           std::span<const HitCandidate> theirs) {
    SCOTTY_ASSERT(ours.size(), ==, rays.rays.size());
    SCOTTY_ASSERT(theirs.size(), ==, rays.rays.size());
    HitComparison out;
    out.rays = rays.rays.size();
    out.any_hit = rays.any_hit;
    std::optional<reference::EmbreeTracer> embree;  // only for adjudication
    for (std::size_t i = 0; i < rays.rays.size(); ++i) {
        HitMismatch found{static_cast<std::uint32_t>(i), ours[i], theirs[i], {}};
        if (ours[i].primitive == theirs[i].primitive) {
            const bool is_hit = !rays.any_hit && ours[i].primitive != reference::kNone;
            const double gap = is_hit ? relative_gap(ours[i], theirs[i]) : 0.0;
            if (gap <= kDistanceGap) {
                out.largest_gap = std::max(out.largest_gap, gap);
                ++out.agree;
                continue;
            }
        }
        if (rays.any_hit) {
            if (!embree) embree.emplace(scene);
            found.verdict = reference::adjudicate_occluded(
                scene, rays.rays[i], ours[i].primitive != 0, theirs[i].primitive != 0,
                embree->closest(rays.rays[i]));
        } else {
            found.verdict = reference::adjudicate_closest(scene, rays.rays[i],
                                                          hit_of(scene, rays.rays[i], ours[i]),
                                                          hit_of(scene, rays.rays[i], theirs[i]));
        }
        switch (found.verdict.verdict) {
            case Disagreement::none:
                ++out.agree;
                continue;
            case Disagreement::tie:
                ++out.ties;
                break;
            case Disagreement::grazing:
                ++out.grazing;
                break;
            case Disagreement::embree_wrong:
                ++out.theirs_wrong;
                break;
            case Disagreement::ours_wrong:
                ++out.ours_wrong;
                break;
        }
        const bool ours_wrong = found.verdict.verdict == Disagreement::ours_wrong;
        const auto place =
            ours_wrong ? std::find_if(out.mismatches.begin(), out.mismatches.end(),
                                      [](const HitMismatch& m) {
                                          return m.verdict.verdict != Disagreement::ours_wrong;
                                      })
                       : out.mismatches.end();
        out.mismatches.insert(place, std::move(found));
        if (out.mismatches.size() > kKept) out.mismatches.pop_back();
    }
    return out;
}

std::string to_text(const HitComparison& c) {
    std::string text = fmt::format(
        "{}: {} rays; {} agree (t within {:.2g}, relatively), {} ties, {} grazing, "
        "{} theirs wrong, {} ours wrong\n",
        c.passed() ? "passed" : "FAILED", c.rays, c.agree, c.largest_gap, c.ties, c.grazing,
        c.theirs_wrong, c.ours_wrong);
    for (const HitMismatch& m : c.mismatches) {
        // The reference is another tracer's, whatever adjudication calls it.
        text += fmt::format("  ray {}: ours {}, theirs {}: {}: {}\n", m.ray,
                            text_of(m.ours, c.any_hit), text_of(m.theirs, c.any_hit),
                            m.verdict.verdict == Disagreement::embree_wrong
                                ? "theirs wrong"
                                : to_string(m.verdict.verdict),
                            m.verdict.explanation);
    }
    return text;
}

}  // namespace scotty::verify
