/// merge_intersections: the closest gathered hit; and, now that the final hit is known, whether a
/// ray was kept out of a box that it had to enter.
#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "reference/numerics/intersect_triangle.h"
#include "verify/base/same_bits.h"
#include "verify/invariants/check_state.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records and triangle tests

namespace {

HitCandidate least_of(std::span<const HitCandidate> hits) {
    HitCandidate best{kInfinity, kNone};
    for (const HitCandidate& hit : hits) {
        if (closer(hit.t, hit.primitive, best.t, best.primitive)) best = hit;
    }
    return best;
}

/// The full hit on one triangle; no_hit() if the ray misses it.
Hit hit_of(const Scene& scene, const Ray& ray, std::uint32_t primitive) {
    if (primitive >= scene.triangles.size()) return no_hit();
    const auto& corners = scene.triangles[primitive];
    Hit hit = no_hit();
    if (intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                           scene.vertices[corners[0]], scene.vertices[corners[1]],
                           scene.vertices[corners[2]], hit)) {
        hit.primitive = primitive;
    }
    return hit;
}

/// Required: final hit not nearer than the entry; in any-hit queries, no hit at all.
void check_kept_out(CheckState& state, const StageView& stage, std::span<const Hit> merged) {
    const auto& kept_out = state.traversal.kept_out;
    for (std::uint32_t ray = 0; ray < kept_out.size() && ray < merged.size(); ++ray) {
        const auto& place = kept_out[ray];
        if (place.node == kNotApplicable) continue;
        const Hit& hit = merged[ray];
        const bool required =
            state.traversal.asks_any ? !is_hit(hit) : !is_hit(hit) || !(hit.t < place.entry);
        if (!required) continue;
        Failure failure =
            failure_at(stage, invariant::kRequiredPresent,
                       "a ray was kept out of a node although its final hit is not nearer");
        failure.launch = place.launch;
        failure.level = place.level;
        failure.node = place.node;
        failure.block = place.block;
        failure.ray = ray;
        failure.field = fmt::format("queue of node {}", place.node);
        failure.expected = fmt::format("the ray, which enters at {}", exact(place.entry));
        failure.found = fmt::format("culled; final hit: {}", exact(hit));
        state.add(std::move(failure));
        return;
    }
}

}  // namespace

void check_merge(CheckState& state, const StageView& stage) {
    const TraversalState& traversal = state.traversal;
    const auto rays = stage.get(buffers::rays);
    const auto n = static_cast<std::uint32_t>(rays.size());
    const auto merged = expect_buffer(state, stage, buffers::merged, n);
    if (merged.empty()) return;
    const bool packed_mode = state.parameters.hit_mode == HitMode::packed;
    const auto packed = stage.get(buffers::packed_hits);
    const auto counts = stage.get(buffers::hit_counts);
    const auto hits = stage.get(buffers::hits);
    const std::size_t capacity = n == 0 ? 0 : hits.size() / n;
    if (packed_mode ? packed.size() != n : counts.size() != n) {
        state.add(failure_at(stage, invariant::kHandOver, "the gathered hits are missing"));
        return;
    }
    const bool followed = traversal.running && traversal.best.size() == n;
    for (std::uint32_t ray = 0; ray < n; ++ray) {
        HitCandidate best{kInfinity, kNone};
        if (packed_mode) {
            if (packed[ray] != kNoPackedHit) {
                best = {std::bit_cast<float>(static_cast<std::uint32_t>(packed[ray] >> 32)),
                        static_cast<std::uint32_t>(packed[ray])};
            }
        } else {
            const std::size_t count = counts[ray] < capacity ? counts[ray] : capacity;
            best = least_of(hits.subspan(ray * capacity, count));
        }
        Failure failure = failure_at(stage, invariant::kMerge, "");
        failure.ray = ray;
        failure.field = fmt::format("merged[{}]", ray);
        if (followed && (best.primitive != traversal.best[ray].primitive ||
                         std::bit_cast<std::uint32_t>(best.t) !=
                             std::bit_cast<std::uint32_t>(traversal.best[ray].t))) {
            const HitCandidate& seen = traversal.best[ray];
            failure.sentence = "the gathered hits are not those that the levels have appended";
            failure.expected =
                fmt::format("closest: primitive {} at t {}", seen.primitive, exact(seen.t));
            failure.found =
                fmt::format("closest: primitive {} at t {}", best.primitive, exact(best.t));
            state.add(std::move(failure));
            return;
        }
        const Hit expected =
            best.primitive == kNone ? no_hit() : hit_of(state.scene, rays[ray], best.primitive);
        if (same_bits(expected, merged[ray])) continue;
        failure.sentence = "not the closest of the ray's gathered hits";
        failure.expected = exact(expected);
        failure.found = exact(merged[ray]);
        state.add(std::move(failure));
        break;
    }
    check_kept_out(state, stage, merged);
}

}  // namespace scotty::verify
