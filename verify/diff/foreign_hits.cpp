/// The hits of another program: what rays have gathered in leaves, and what came out.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reference/truth/tracers.h"
#include "verify/capture/failure.h"
#include "verify/diff/foreign_run.h"
#include "verify/diff/judge_box.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Disagreement;
using reference::Hit;
using reference::HitCandidate;
using reference::kNone;
using reference::kNotApplicable;
using reference::StageView;
using reference::TriangleVerdict;

namespace {

/// The relative gap of t up to which two tracers agree on a hit (oracles/ray_compare.cpp).
constexpr double kDistanceGap = 1e-4;

std::string text_of(const HitCandidate& hit) {
    return hit.primitive == kNone ? std::string("no hit")
                                  : fmt::format("primitive {} at t {:.6g}", hit.primitive, hit.t);
}

class HitsCheck {
 public:
    HitsCheck(const ForeignTree& tree, bool culls, const ForeignQuery& query,
              ForeignVerdict& verdict)
        : scene_(tree.input.scene), tree_(tree), culls_(culls), query_(query), verdict_(verdict) {}

    void judge_gathered(std::uint32_t ray, std::span<const HitCandidate> gathered,
                        std::uint32_t claimed) {
        verdict_.judged("hits");
        if (claimed > gathered.size()) {
            verdict_.fail("hits", kNotApplicable, ray,
                          "the ray's counter of hits is beyond its slots: hits were lost, or "
                          "written over another ray's",
                          fmt::format("{} hits in {} slots", claimed, gathered.size()),
                          "no more than there is room for");
        }
        for (const HitCandidate& hit : gathered) judge_claim(ray, hit);
        for (const HitCandidate& hit : query_.leaf_hits[ray]) judge_presence(ray, hit, gathered);
    }

    void judge_answer(std::uint32_t ray, const HitCandidate& answer,
                      std::span<const HitCandidate> gathered, bool knows_gathered) {
        verdict_.judged("merged");
        if (query_.asks_any) return judge_occlusion(ray, answer);
        const Hit& truth = query_.truth[ray];
        const HitCandidate nearest = nearest_of(gathered);
        if (knows_gathered && !(answer.t == nearest.t) &&
            (is_finite(answer) || is_finite(nearest))) {
            verdict_.fail("merged", kNotApplicable, ray,
                          "the answer is not the nearest of the hits that the ray has gathered",
                          text_of(answer), text_of(nearest));
            return;
        }
        if (answer.primitive == truth.primitive && close(answer.t, truth.t)) return;
        if (verdict_.has_many("merged")) {  // each ruling may look at every triangle
            verdict_.fail("merged", kNotApplicable, ray, "", "", "");
            return;
        }
        const reference::Adjudication ruling =
            adjudicate_closest(scene_, query_.rays[ray], truth, complete(ray, answer));
        if (ruling.verdict == Disagreement::none) return;
        if (ruling.verdict != Disagreement::embree_wrong) return verdict_.excuse("merged");
        verdict_.fail("merged", leaf_of(truth.primitive), ray, "the answer is not the closest hit",
                      text_of(answer), text_of({truth.t, truth.primitive}));
    }

 private:
    static bool is_finite(const HitCandidate& hit) { return hit.primitive != kNone; }
    static bool close(float a, float b) {
        return a == b || std::abs(double{a} - double{b}) <=
                             kDistanceGap * std::max(std::abs(double{a}), std::abs(double{b}));
    }
    static HitCandidate nearest_of(std::span<const HitCandidate> hits) {
        HitCandidate nearest{reference::kInfinity, kNone};
        for (const HitCandidate& hit : hits) {
            if (hit.t < nearest.t) nearest = hit;
        }
        return nearest;
    }
    std::uint32_t leaf_of(std::uint32_t primitive) const {
        return primitive < tree_.leaf_of.size() ? tree_.leaf_of[primitive] : kNotApplicable;
    }
    /// Other programs have barycentrics of their own: those of the primitive stand in.
    Hit complete(std::uint32_t ray, const HitCandidate& answer) const {
        if (answer.primitive >= scene_.triangles.size()) return {answer.t, answer.primitive, 0, 0};
        const TriangleVerdict truth = judge_triangle(scene_, answer.primitive, query_.rays[ray]);
        return {answer.t, answer.primitive, static_cast<float>(truth.u),
                static_cast<float>(truth.v)};
    }

    /// A gathered hit must be one.
    void judge_claim(std::uint32_t ray, const HitCandidate& hit) {
        const auto& expected = query_.leaf_hits[ray];
        const bool known = std::any_of(expected.begin(), expected.end(), [&](const auto& other) {
            return other.primitive == hit.primitive && close(other.t, hit.t);
        });
        if (known) return;
        if (hit.primitive >= scene_.triangles.size()) {
            verdict_.fail("hits", kNotApplicable, ray, "the ray has gathered a hit of no primitive",
                          text_of(hit),
                          fmt::format("primitives below {}", scene_.triangles.size()));
            return;
        }
        const TriangleVerdict truth = judge_triangle(scene_, hit.primitive, query_.rays[ray]);
        const bool there = truth.verdict != reference::Verdict::miss &&
                           (close(hit.t, static_cast<float>(truth.t)) ||
                            std::abs(double{hit.t} - truth.t) <= truth.t_margin);
        const std::uint32_t leaf = leaf_of(hit.primitive);
        if (!there) {
            verdict_.fail("hits", leaf, ray, "the ray has gathered a hit that is none",
                          text_of(hit), describe(truth));
        } else if (truth.verdict == reference::Verdict::grazing) {
            verdict_.excuse("hits");
        }
    }

    /// A leaf's closest hit must be gathered: without culling always, with it if it is the answer.
    void judge_presence(std::uint32_t ray, const HitCandidate& expected,
                        std::span<const HitCandidate> gathered) {
        const auto matches = [&](bool same_primitive) {
            return std::any_of(gathered.begin(), gathered.end(), [&](const HitCandidate& hit) {
                return close(hit.t, expected.t) &&
                       (!same_primitive || hit.primitive == expected.primitive);
            });
        };
        if (matches(true)) return;
        const Hit& truth = query_.truth[ray];
        const bool behind =
            is_hit(truth) && (query_.asks_any ? !gathered.empty() : expected.t > truth.t);
        if (culls_ && behind) return;
        const TriangleVerdict judged = judge_triangle(scene_, expected.primitive, query_.rays[ray]);
        if (matches(false) || judged.verdict != reference::Verdict::hit) {
            return verdict_.excuse("hits");
        }
        verdict_.fail("hits", leaf_of(expected.primitive), ray,
                      "the closest hit of a leaf is missing from what the ray has gathered",
                      fmt::format("{} other hits", gathered.size()), text_of(expected));
    }

    void judge_occlusion(std::uint32_t ray, const HitCandidate& answer) {
        const Hit& truth = query_.truth[ray];
        const bool said = answer.primitive != kNone;
        if (said == is_hit(truth)) return;
        const reference::Adjudication ruling =
            adjudicate_occluded(scene_, query_.rays[ray], is_hit(truth), said, truth);
        if (ruling.verdict == Disagreement::none) return;
        if (ruling.verdict != Disagreement::embree_wrong) return verdict_.excuse("merged");
        verdict_.fail("merged", leaf_of(truth.primitive), ray,
                      "the answer of an any-hit query is wrong", said ? "occluded" : "free",
                      said ? "free" : "occluded by " + text_of({truth.t, truth.primitive}));
    }

    const reference::Scene& scene_;
    const ForeignTree& tree_;
    bool culls_;
    const ForeignQuery& query_;
    ForeignVerdict& verdict_;
};

}  // namespace

void judge_foreign_hits(const StageView& stage, const ForeignTree& tree, bool culls,
                        const ForeignQuery& query, ForeignVerdict& verdict) {
    const auto counts = stage.get(buffers::hit_counts);
    const auto hits = stage.get(buffers::hits);
    const auto hits_given = stage.get<std::uint32_t>("hits_given");
    const auto merged = stage.get(buffers::merged);
    const auto merged_given = stage.get<std::uint32_t>("merged_given");
    HitsCheck check(tree, culls, query, verdict);
    const std::size_t slots = hits.size() / query.rays.size();
    for (std::uint32_t ray = 0; ray < query.count(); ++ray) {
        if (!query.sound[ray]) continue;
        std::span<const HitCandidate> gathered;
        const bool knows_gathered = ray < hits_given.size() && hits_given[ray] != 0;
        if (knows_gathered) {
            gathered = hits.subspan(ray * slots, std::min<std::size_t>(counts[ray], slots));
            check.judge_gathered(ray, gathered, counts[ray]);
        }
        if (ray < merged_given.size() && merged_given[ray] != 0) {
            check.judge_answer(ray, {merged[ray].t, merged[ray].primitive}, gathered,
                               knows_gathered);
        }
    }
}

}  // namespace scotty::verify
