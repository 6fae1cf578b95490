/// Who is right where two tracers disagree.
///
/// A claim ("primitive p at t") stands if judge_triangle() says that p may be hit and t is where
/// the ray meets p, within the margin. A claim that does not stand is wrong. Of two that stand, the
/// nearer wins if its primitive *must* be hit, and then the other is wrong; if it only may be, the
/// ray grazes it, and the farther answer is right too, unless it also passed something that must be
/// hit - which takes a scan of all triangles, but only for the rare ray that gets this far.
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "reference/numerics/intersect_triangle.h"
#include "reference/truth/ray_triangle_double.h"
#include "reference/truth/tracers.h"

namespace scotty::reference {
namespace {

/// What both sides are, so that swapping roles swaps verdicts and nothing else.
struct Side {
    const char* name;
    Disagreement wrong;
};
constexpr Side kOurs{"ours", Disagreement::ours_wrong};
constexpr Side kEmbree{"Embree's", Disagreement::embree_wrong};

std::string claim_text(const Side& side, const Hit& hit) {
    return is_hit(hit)
               ? fmt::format("{} is primitive {} at t {:.9g}", side.name, hit.primitive, hit.t)
               : fmt::format("{} is a miss", side.name);
}

/// Empty where the claim stands; else why not.
std::string refute(const Scene& scene, const Ray& ray, const Hit& hit) {
    if (hit.primitive >= scene.triangles.size()) {
        return fmt::format("there is no primitive {}, the scene has {}", hit.primitive,
                           scene.triangles.size());
    }
    if (!(ray.t_min <= hit.t && hit.t < ray.t_max)) {
        return fmt::format("t {:.9g} is not within the ray's [{:.9g}, {:.9g})", hit.t, ray.t_min,
                           ray.t_max);
    }
    const TriangleVerdict truth = judge_triangle(scene, hit.primitive, ray);
    const bool t_agrees = std::abs(double{hit.t} - truth.t) <= truth.t_margin;
    const bool uv_agrees = std::abs(double{hit.u} - truth.u) <= truth.uv_margin &&
                           std::abs(double{hit.v} - truth.v) <= truth.uv_margin;
    if (truth.verdict == Verdict::miss || !t_agrees) {
        return fmt::format("primitive {} {}", hit.primitive, describe(truth));
    }
    if (!uv_agrees) {
        return fmt::format(
            "primitive {}: u, v are {:.9g}, {:.9g}, but should be {:.9g}, {:.9g} +- {:.2g}",
            hit.primitive, hit.u, hit.v, truth.u, truth.v, truth.uv_margin);
    }
    return {};
}

/// Whether the ray enters the triangle's box, padded by the margin: quick, and true wherever the
/// triangle must be hit or the suite's own test hits it.
bool enters_box(const Ray& ray, const Vec3& inverse, const Vec3& v0, const Vec3& v1,
                const Vec3& v2) {
    const Vec3 low = min_of(min_of(v0, v1), v2);
    const Vec3 high = max_of(max_of(v0, v1), v2);
    const RaySlabs slabs = ray_slabs(ray.origin, inverse, box_pad(ray.origin, low, high));
    return overlaps(clip(intersect_box(slabs, low, high), ray.t_min, ray.t_max));
}

/// A primitive that any tracer must hit before t `limit`, or that the suite's own triangle test
/// hits there (the pipelines promise its very answers); kNone if there is none.
/// `own_test`: whether to ask the suite's test as well.
std::uint32_t passed_over(const Scene& scene, const Ray& ray, double limit, bool own_test) {
    const Vec3 inverse = safe_inverse(ray.direction);
    const RayShear shear = ray_shear(ray.direction);
    const auto count = static_cast<std::uint32_t>(scene.triangles.size());
    for (std::uint32_t id = 0; id < count; ++id) {
        const auto& index = scene.triangles[id];
        if (!enters_box(ray, inverse, scene.vertices[index[0]], scene.vertices[index[1]],
                        scene.vertices[index[2]])) {
            continue;
        }
        const TriangleVerdict truth = judge_triangle(scene, id, ray);
        if (truth.verdict == Verdict::miss) continue;
        if (truth.verdict == Verdict::hit && truth.t + truth.t_margin < limit) return id;
        Hit hit = no_hit();
        if (own_test &&
            intersect_triangle(ray, inverse, shear, scene.vertices[index[0]],
                               scene.vertices[index[1]], scene.vertices[index[2]], hit) &&
            double{hit.t} < limit) {
            return id;
        }
    }
    return kNone;
}

/// Whether `side`'s answer, which stands in itself, comes too late: something nearer was passed
/// over. Ours is held to the suite's own triangle test too.
Adjudication judge_lateness(const Scene& scene, const Ray& ray, const Hit& hit, const Side& side) {
    double limit = ray.t_max;
    if (is_hit(hit)) limit = double{hit.t} - judge_triangle(scene, hit.primitive, ray).t_margin;
    const std::uint32_t missed =
        passed_over(scene, ray, limit, side.wrong == Disagreement::ours_wrong);
    if (missed == kNone) return {};
    return {side.wrong, fmt::format("{}, but before that, primitive {} {}", claim_text(side, hit),
                                    missed, describe(judge_triangle(scene, missed, ray)))};
}

/// `nearer` stands as a claim; `farther` is a later hit or a miss, of side `far_side`.
Adjudication judge_farther(const Scene& scene, const Ray& ray, const Hit& nearer,
                           const Hit& farther, const Side& far_side) {
    const TriangleVerdict truth = judge_triangle(scene, nearer.primitive, ray);
    if (truth.verdict == Verdict::hit) {
        return {far_side.wrong,
                fmt::format("{}, but primitive {} {}", claim_text(far_side, farther),
                            nearer.primitive, describe(truth))};
    }
    Adjudication late = judge_lateness(scene, ray, farther, far_side);
    if (late.verdict != Disagreement::none) return late;
    return {Disagreement::grazing,
            fmt::format("primitive {} {}", nearer.primitive, describe(truth))};
}

Adjudication judge_two_hits(const Scene& scene, const Ray& ray, const Hit& ours,
                            const Hit& embree) {
    if (ours.primitive == embree.primitive)
        return {};  // both claims stand: t agrees with the truth
    const TriangleVerdict our_truth = judge_triangle(scene, ours.primitive, ray);
    const TriangleVerdict embree_truth = judge_triangle(scene, embree.primitive, ray);
    const double gap = std::abs(double{ours.t} - double{embree.t});
    const double margin = our_truth.t_margin + embree_truth.t_margin;
    if (gap <= margin) {
        return {Disagreement::tie,
                fmt::format("{}; {}; {:.2g} apart (margin {:.2g})", claim_text(kOurs, ours),
                            claim_text(kEmbree, embree), gap, margin)};
    }
    return ours.t < embree.t ? judge_farther(scene, ray, ours, embree, kEmbree)
                             : judge_farther(scene, ray, embree, ours, kOurs);
}

}  // namespace

const char* to_string(Disagreement verdict) {
    switch (verdict) {
        case Disagreement::none:
            return "none";
        case Disagreement::tie:
            return "tie";
        case Disagreement::grazing:
            return "grazing edge";
        case Disagreement::ours_wrong:
            return "ours wrong";
        case Disagreement::embree_wrong:
            return "Embree wrong";
    }
    return "unknown";
}

Adjudication adjudicate_closest(const Scene& scene, const Ray& ray, const Hit& ours,
                                const Hit& embree) {
    if (!is_hit(ours) && !is_hit(embree)) return {};
    const std::string against_ours = is_hit(ours) ? refute(scene, ray, ours) : "";
    if (!against_ours.empty()) {
        return {kOurs.wrong, claim_text(kOurs, ours) + ", but " + against_ours};
    }
    const std::string against_embree = is_hit(embree) ? refute(scene, ray, embree) : "";
    if (!against_embree.empty()) {
        // Embree's mistake does not make ours right.
        Adjudication late = judge_lateness(scene, ray, ours, kOurs);
        if (late.verdict != Disagreement::none) return late;
        return {kEmbree.wrong, claim_text(kEmbree, embree) + ", but " + against_embree};
    }
    if (!is_hit(ours)) return judge_farther(scene, ray, embree, ours, kOurs);
    if (!is_hit(embree)) return judge_farther(scene, ray, ours, embree, kEmbree);
    return judge_two_hits(scene, ray, ours, embree);
}

Adjudication adjudicate_occluded(const Scene& scene, const Ray& ray, bool ours, bool embree,
                                 const Hit& closest_by_embree) {
    if (ours == embree) return {};
    const Side& blocked = ours ? kOurs : kEmbree;
    const Side& open = ours ? kEmbree : kOurs;
    const std::uint32_t missed =
        passed_over(scene, ray, ray.t_max, open.wrong == Disagreement::ours_wrong);
    if (missed != kNone) {
        return {open.wrong, fmt::format("{} is not occluded, but primitive {} {}", open.name,
                                        missed, describe(judge_triangle(scene, missed, ray)))};
    }
    // Nothing must be hit; is there anything that may be?
    const auto count = static_cast<std::uint32_t>(scene.triangles.size());
    for (std::uint32_t id = 0; id < count; ++id) {
        const TriangleVerdict truth = judge_triangle(scene, id, ray);
        if (truth.verdict != Verdict::grazing) continue;
        return {Disagreement::grazing, fmt::format("primitive {} {}", id, describe(truth))};
    }
    return {blocked.wrong,
            fmt::format("{} is occluded, but every primitive must be missed; {}", blocked.name,
                        claim_text({"Embree's closest", Disagreement::none}, closest_by_embree))};
}

}  // namespace scotty::reference
