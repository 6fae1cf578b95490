/// intersect: the hits that leaves have appended for the rays in their queues, and the minimum.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "verify/invariants/check_state.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records and triangle tests

namespace {

/// A hit that a leaf has to append to a ray's hits, or may append under `immediate`.
struct LeafHit {
    std::uint32_t ray, primitive, node, block;
    float t;
    bool required;
};

/// All leaf hits of a launch, sorted by ray; those of ray r begin at `first[r]`.
struct LeafHits {
    std::vector<LeafHit> hits;
    std::vector<std::uint32_t> first;
};

using FoundHits = tbb::enumerable_thread_specific<std::vector<LeafHit>>;

/// Adds the hit, unless there is none or it must not count.
void add_hit(std::vector<LeafHit>& found, const HitCandidate& hit, std::uint32_t ray,
             std::uint32_t node, std::uint32_t block, float limit, EarlyOut policy) {
    if (hit.primitive == kNone) return;
    const bool near = !(hit.t > limit);
    if (!near && policy == EarlyOut::level) return;
    found.push_back({ray, hit.primitive, node, block, hit.t, near});
}

/// Of a level with a queue of pairs: the leaves that its rays enter from their nodes, or their
/// subtrees.
void find_pair_hits(const CheckState& state, const StageView& stage, FoundHits& found) {
    const auto rays = stage.get(buffers::rays);
    const auto pairs = stage.get(buffers::pairs);
    const auto minimum = stage.get(buffers::minimum);
    const WideBvh& bvh = state.bvh;
    const NodeBoxes root = boxes_of(bvh, 0);
    const bool subtrees = bvh.is_level_of_subtrees(stage.level);
    const std::size_t count = stage.level == 0 ? rays.size() : pairs.size();
    const auto per_block = static_cast<std::uint32_t>(state.parameters.rays_per_block);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const auto& range) {
        auto& local = found.local();
        for (std::size_t p = range.begin(); p != range.end(); ++p) {
            const NodeRay pair =
                stage.level == 0 ? NodeRay{0, static_cast<std::uint32_t>(p)} : pairs[p];
            // check_pairs reports what is no ray or node of the level.
            if (pair.ray >= rays.size() || pair.node >= bvh.inner_count()) continue;
            const Ray& ray = rays[pair.ray];
            const float limit = pair.ray < minimum.size() ? minimum[pair.ray] : kInfinity;
            const auto block = static_cast<std::uint32_t>(p / per_block);
            const auto add = [&](const HitCandidate& hit, std::uint32_t node) {
                add_hit(local, hit, pair.ray, node, block, limit, state.parameters.early_out);
            };
            if (subtrees) {
                add(hit_of_subtree(bvh, pair.node, ray, state.traversal.asks_any), kNotApplicable);
                continue;
            }
            const NodeBoxes boxes = boxes_of(bvh, pair.node);
            const ExpectedChildren children = expected_pairs(boxes, root, ray, limit);
            for (std::uint32_t c = 0; c < boxes.width; ++c) {
                if ((children.overlapped >> c & 1u) == 0) continue;
                const std::uint32_t ref = bvh.node_refs[boxes.child[c]];
                if (!is_leaf(ref)) continue;
                add(closest_in_leaf(bvh, bvh.leaves[ref_index(ref)], ray), boxes.child[c]);
            }
        }
    });
}

void find_queue_hits(const CheckState& state, const StageView& stage, FoundHits& found) {
    const auto rays = stage.get(buffers::rays);
    const auto counts = stage.get(buffers::node_counts);
    const auto offsets = stage.get(buffers::queue_offsets);
    const auto queue = stage.get(buffers::queue);
    const auto minimum = stage.get(buffers::minimum);
    const EarlyOut policy = state.parameters.early_out;
    const std::uint32_t first_node = state.bvh.level_begins[stage.level];
    const auto nodes = state.bvh.level_begins[stage.level + 1] - first_node;
    const bool has_children = stage.level + 1 < state.bvh.level_count();
    const auto& block_offsets = state.traversal.block_offsets;
    const auto per_block = static_cast<std::uint32_t>(state.parameters.rays_per_block);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, nodes), [&](const auto& range) {
        auto& local = found.local();
        for (std::uint32_t node = range.begin(); node != range.end(); ++node) {
            const std::uint32_t ref = state.bvh.node_refs[first_node + node];
            const bool pushes = !is_leaf(ref) && has_children;
            if (pushes || node >= counts.size() || node >= offsets.size()) continue;
            for (std::uint32_t p = 0; p < counts[node]; ++p) {
                const std::size_t at = std::size_t{offsets[node]} + p;
                // The root's queue holds all rays. check_queues reports what is no ray id.
                const std::uint32_t ray =
                    stage.level == 0 ? p : (at < queue.size() ? queue[at] : kNone);
                if (ray >= rays.size()) break;
                const float limit = ray < minimum.size() ? minimum[ray] : kInfinity;
                const HitCandidate hit =
                    is_leaf(ref)
                        ? closest_in_leaf(state.bvh, state.bvh.leaves[ref_index(ref)], rays[ray])
                        : hit_of_subtree(state.bvh, ref_index(ref), rays[ray],
                                         state.traversal.asks_any);
                const std::uint32_t block =
                    (node < block_offsets.size() ? block_offsets[node] : 0u) + p / per_block;
                add_hit(local, hit, ray, first_node + node, block, limit, policy);
            }
        }
    });
}

LeafHits expected_hits(const CheckState& state, const StageView& stage) {
    const auto rays = stage.get(buffers::rays);
    FoundHits found;
    if (state.parameters.queues == QueueKind::pairs) {
        find_pair_hits(state, stage, found);
    } else {
        find_queue_hits(state, stage, found);
    }
    LeafHits out;
    out.first.assign(rays.size() + 1, 0);
    for (const auto& local : found) {
        for (const LeafHit& hit : local) ++out.first[hit.ray + 1];
    }
    for (std::size_t r = 0; r < rays.size(); ++r) out.first[r + 1] += out.first[r];
    out.hits.resize(out.first.back());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (const auto& local : found) {
        for (const LeafHit& hit : local) out.hits[next[hit.ray]++] = hit;
    }
    return out;
}

std::string describe(float t, std::uint32_t primitive) {
    return fmt::format("primitive {} at t {}", primitive, exact(t));
}

Failure leaf_failure(const StageView& stage, std::uint32_t ray, const LeafHit* hit,
                     std::string sentence) {
    Failure failure = failure_at(stage, invariant::kLeafHits, std::move(sentence));
    failure.ray = ray;
    failure.field = buffers::hits.name;
    if (hit != nullptr) {
        failure.node = hit->node;
        failure.block = hit->block;
    }
    return failure;
}

/// Compares the slots that a launch has appended with the leaves' hits, as multisets.
void check_appended(const StageView& stage, std::uint32_t ray, std::span<const LeafHit> expected,
                    std::span<const HitCandidate> appended, std::vector<Failure>& failures) {
    std::vector<bool> matched(expected.size(), false);
    for (const HitCandidate& hit : appended) {
        std::size_t i = 0;
        while (i < expected.size() && (matched[i] || expected[i].primitive != hit.primitive ||
                                       std::bit_cast<std::uint32_t>(expected[i].t) !=
                                           std::bit_cast<std::uint32_t>(hit.t))) {
            ++i;
        }
        if (i < expected.size()) {
            matched[i] = true;
            continue;
        }
        Failure failure = leaf_failure(stage, ray, nullptr, "a hit that no leaf of this level has");
        failure.expected = "no such hit";
        failure.found = describe(hit.t, hit.primitive);
        failures.push_back(std::move(failure));
    }
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (matched[i] || !expected[i].required) continue;
        Failure failure = leaf_failure(stage, ray, &expected[i], "a leaf's closest hit is missing");
        failure.expected = describe(expected[i].t, expected[i].primitive);
        failure.found = fmt::format("{} other hits appended", appended.size());
        failures.push_back(std::move(failure));
    }
}

/// The hits that were there before a launch must be there after it.
void check_kept(const CheckState& state, const StageView& stage, std::uint32_t ray,
                std::span<const HitCandidate> kept, std::vector<Failure>& failures) {
    if (kept.empty() || sum_of_hits(kept) == state.traversal.hit_sums[ray]) return;
    Failure failure =
        leaf_failure(stage, ray, nullptr, "the hits that levels before have gathered changed");
    failure.expected = fmt::format("the {} hits as they were", kept.size());
    failure.found =
        fmt::format("others, the first is {}", describe(kept.front().t, kept.front().primitive));
    failures.push_back(std::move(failure));
}

std::uint64_t pack(const LeafHit& hit) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(hit.t)} << 32 | hit.primitive;
}

/// Packed mode: the least of the previous hit and the leaves' hits. If any hit will do and the
/// minimum is read while it changes, any of the leaves' hits may have come first.
void check_packed(const StageView& stage, std::uint32_t ray, std::span<const LeafHit> expected,
                  std::uint64_t before, std::uint64_t after, bool free_choice,
                  std::vector<Failure>& failures) {
    std::uint64_t least = before;
    bool is_candidate = after == before && (before != kNoPackedHit || expected.empty());
    const LeafHit* winner = nullptr;
    for (const LeafHit& hit : expected) {
        is_candidate = is_candidate || (pack(hit) == after && after < before);
        if (pack(hit) < least) {
            least = pack(hit);
            winner = &hit;
        }
    }
    if (after == least || (free_choice && is_candidate)) return;
    const auto shown = [](std::uint64_t packed) {
        return packed == kNoPackedHit ? std::string("no hit") : fmt::format("{:#018x}", packed);
    };
    Failure failure = leaf_failure(stage, ray, winner, "not the closest of the leaves' hits");
    failure.field = fmt::format("packed_hits[{}]", ray);
    failure.expected = shown(least);
    failure.found = shown(after);
    failures.push_back(std::move(failure));
}

}  // namespace

std::uint64_t sum_of_hits(std::span<const HitCandidate> hits) {
    std::uint64_t sum = 0;
    for (const HitCandidate& hit : hits) {
        // Odd factors and shifts mix all bits (splitmix64).
        std::uint64_t mixed =
            std::uint64_t{std::bit_cast<std::uint32_t>(hit.t)} << 32 | hit.primitive;
        mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9u;
        mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebu;
        sum += mixed ^ mixed >> 31;
    }
    return sum;
}

void check_leaves(CheckState& state, const StageView& stage) {
    if (stage.level == kNotApplicable || stage.level + 1 >= state.bvh.level_begins.size()) return;
    const auto rays = stage.get(buffers::rays);
    const auto n = static_cast<std::uint32_t>(rays.size());
    const bool packed_mode = state.parameters.hit_mode == HitMode::packed;
    // A root that pushes its rays on has no hits, and need not show any.
    const bool root = stage.level == 0;
    if (root &&
        stage.find(packed_mode ? buffers::packed_hits.name : buffers::hit_counts.name) == nullptr)
        return;
    const TraversalState& traversal = state.traversal;
    const LeafHits expected = expected_hits(state, stage);
    const auto of_ray = [&](std::uint32_t ray) {
        return std::span<const LeafHit>(expected.hits)
            .subspan(expected.first[ray], expected.first[ray + 1] - expected.first[ray]);
    };
    std::vector<Failure> failures;
    std::uint64_t appended_total = 0;
    if (packed_mode) {
        const auto packed = expect_buffer(state, stage, buffers::packed_hits, n);
        const bool free_choice =
            traversal.asks_any && state.parameters.early_out == EarlyOut::immediate;
        for (std::uint32_t ray = 0; ray < packed.size(); ++ray) {
            const std::uint64_t before =
                ray < traversal.packed.size() && !root ? traversal.packed[ray] : kNoPackedHit;
            check_packed(stage, ray, of_ray(ray), before, packed[ray], free_choice, failures);
        }
        appended_total = expected.hits.size();
    } else {
        const auto counts = expect_buffer(state, stage, buffers::hit_counts, n);
        const auto hits = stage.get(buffers::hits);
        const std::size_t capacity = n == 0 ? 0 : hits.size() / n;
        for (std::uint32_t ray = 0; ray < counts.size(); ++ray) {
            const std::uint32_t before =
                ray < traversal.hit_counts.size() && !root ? traversal.hit_counts[ray] : 0;
            if (counts[ray] < before || counts[ray] > capacity) {
                Failure failure =
                    leaf_failure(stage, ray, nullptr,
                                 counts[ray] < before ? "hits have vanished"
                                                      : "more hits than the ray has slots");
                if (counts[ray] > capacity) failure.invariant = invariant::kSlotWrittenOnce;
                failure.field = fmt::format("hit_counts[{}]", ray);
                failure.expected = fmt::format("{}..{}", before, capacity);
                failure.found = std::to_string(counts[ray]);
                failures.push_back(std::move(failure));
                continue;
            }
            appended_total += counts[ray] - before;
            check_kept(state, stage, ray, hits.subspan(ray * capacity, before), failures);
            check_appended(stage, ray, of_ray(ray),
                           hits.subspan(ray * capacity + before, counts[ray] - before), failures);
        }
        const bool free_count = state.parameters.early_out == EarlyOut::immediate;
        if (!free_count && appended_total != expected.hits.size()) {
            Failure failure = failure_at(stage, invariant::kConservation,
                                         "the level's leaves found another number of hits than "
                                         "were appended");
            failure.field = "hit_counts, summed over this level";
            failure.expected = std::to_string(expected.hits.size());
            failure.found = std::to_string(appended_total);
            failures.push_back(std::move(failure));
        }
    }
    state.counts.leaf_hits += appended_total;
    state.add_sorted(std::move(failures));
}

void check_minimum(CheckState& state, const StageView& stage) {
    const EarlyOut policy = state.parameters.early_out;
    if (policy == EarlyOut::off) return;
    const TraversalState& traversal = state.traversal;
    const auto minimum = expect_buffer(state, stage, buffers::minimum, traversal.rays.size());
    if (stage.kind == StageKind::publish_minimum) {
        expect_same<float>(state, stage, invariant::kMinimum, buffers::lowered.name, minimum,
                           stage.get(buffers::lowered), true,
                           "not the nearest distance that is published",
                           [](float t) { return exact(t); });
    }
    // Under `level` an intersect launch reads the minimum published before it, unchanged.
    const bool unchanged = policy == EarlyOut::level && stage.kind != StageKind::publish_minimum;
    for (std::size_t ray = 0; ray < minimum.size(); ++ray) {
        const HitCandidate& best = traversal.best[ray];
        const float before = traversal.minimum[ray];
        const bool hit = best.primitive != kNone;
        const float expected =
            unchanged ? before : (!hit ? kInfinity : (traversal.asks_any ? kDone : best.t));
        const float found = minimum[ray];
        // A minimum beyond the ray's end culls nothing, whatever its value.
        const bool beyond = expected == kInfinity && found >= traversal.rays[ray].t_max;
        if (found == expected || beyond) continue;
        Failure failure = failure_at(stage, invariant::kMinimum,
                                     found > before ? "a ray's minimum has risen"
                                                    : "not the nearest of the ray's hits so far");
        failure.ray = static_cast<std::uint32_t>(ray);
        failure.field = fmt::format("minimum[{}]", ray);
        failure.expected = exact(expected);
        failure.found = exact(found);
        state.add(std::move(failure));
        return;
    }
}

}  // namespace scotty::verify
