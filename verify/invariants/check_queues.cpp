/// intersect: the rays that inner nodes have pushed to their children's queues.
///
/// The expected sets are recomputed ray by ray with the reference box test. A ray must be in the
/// queue of every child that it enters no later than its limit, and of no other. The order is free,
/// except inside each block's run.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <bit>
#include <cstdint>
#include <vector>

#include "verify/invariants/check_state.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records

namespace {

/// A broken kernel breaks thousands of rays; at most this many failures per node are written out.
constexpr std::size_t kFailuresPerNode = 4;

struct Tally {
    std::uint64_t entries = 0, pushes = 0, missed = 0, culled = 0;
};

/// One worker's results. `position` and `pushed` are scratch, all kNone between nodes.
struct Worker {
    std::vector<std::uint32_t> position;
    std::vector<std::uint32_t> pushed;
    std::vector<std::uint8_t> block_seen;
    std::vector<ExpectedChildren> expected;
    std::vector<Failure> failures;
    std::vector<KeptOutRay> kept_out;
    Tally tally;
};

/// The buffers of one launch.
struct Launch {
    const StageView& stage;
    const CheckState& state;
    std::uint32_t ray_count = 0;
    std::uint32_t first_node = 0;
    std::uint32_t first_child = 0;
    std::uint32_t per_block = 1;
    std::span<const Ray> rays{};
    std::span<const std::uint32_t> counts{}, offsets{}, queue{}, block_offsets{};
    std::span<const std::uint32_t> child_counts{}, child_offsets{}, child_queue{};
    std::span<const float> minimum{};
};

class NodeCheck {
 public:
    NodeCheck(const Launch& launch, std::uint32_t node, Worker& worker)
        : launch_(launch),
          node_(node),
          worker_(worker),
          boxes_(boxes_of(launch.state.bvh,
                          ref_index(launch.state.bvh.node_refs[launch.first_node + node]))) {
        worker_.pushed.assign(launch.counts[node], 0);
        worker_.expected.clear();
    }

    void run() {
        const std::uint32_t count = launch_.counts[node_];
        for (std::uint32_t p = 0; p < count; ++p) {
            const std::uint32_t ray = entry(p);
            worker_.position[ray] = p;
            worker_.expected.push_back(
                expected_children(boxes_, launch_.rays[ray],
                                  launch_.minimum.empty() ? kInfinity : launch_.minimum[ray]));
        }
        for (std::uint32_t c = 0; c < boxes_.width; ++c) {
            if (boxes_.child[c] != kNone) check_child(c);
        }
        check_conservation();
        for (std::uint32_t p = 0; p < count; ++p) worker_.position[entry(p)] = kNone;
    }

 private:
    std::uint32_t entry(std::uint32_t p) const {
        return launch_.queue.empty() ? p : launch_.queue[launch_.offsets[node_] + p];
    }
    std::uint32_t block_of(std::uint32_t p) const {
        return launch_.block_offsets.empty() ? p / launch_.per_block
                                             : launch_.block_offsets[node_] + p / launch_.per_block;
    }

    void fail(const char* tag, std::uint32_t child, std::uint32_t ray, std::uint32_t block,
              std::string sentence, std::string expected, std::string found,
              const std::uint32_t* slot = nullptr) {
        if (reported_++ >= kFailuresPerNode) return;
        Failure failure = failure_at(launch_.stage, tag, std::move(sentence));
        failure.node = launch_.first_node + node_;
        failure.block = block;
        failure.ray = ray;
        failure.field = fmt::format("queue of child node {}", child);
        failure.expected = std::move(expected);
        failure.found = std::move(found);
        failure.shown_at = slot;
        worker_.failures.push_back(std::move(failure));
    }

    void check_child(std::uint32_t c) {
        const std::uint32_t child = boxes_.child[c];
        const std::uint32_t target = child - launch_.first_child;
        const std::uint32_t begin = launch_.child_offsets[target];
        const std::uint32_t room = launch_.child_offsets[target + 1] - begin;
        const std::uint32_t count = launch_.child_counts[target];
        std::uint32_t distinct = 0;
        if (count > room) {
            fail(invariant::kSlotWrittenOnce, child, kNotApplicable, kNotApplicable,
                 "more rays were pushed than the child's region has slots",
                 fmt::format("at most {} slots", room), fmt::format("{} reserved", count));
        }
        const std::uint32_t shown = count < room ? count : room;
        worker_.block_seen.assign(worker_.pushed.size() / launch_.per_block + 1, 0);
        std::uint32_t run_block = kNone;
        std::uint32_t last_position = 0;
        for (std::uint32_t slot = 0; slot < shown; ++slot) {
            const std::uint32_t* const at = &launch_.child_queue[begin + slot];
            const std::uint32_t ray = *at;
            const std::string where = reported_ < kFailuresPerNode
                                          ? fmt::format("ray {} in slot {}", ray, slot)
                                          : std::string();
            if (ray >= launch_.ray_count) {
                fail(invariant::kSlotWrittenOnce, child, ray, kNotApplicable,
                     "a reserved slot holds no ray id: it was never written",
                     fmt::format("an id below {}", launch_.ray_count), where, at);
                continue;
            }
            const std::uint32_t p = worker_.position[ray];
            if (p == kNone) {
                fail(invariant::kNothingExtra, child, ray, kNotApplicable,
                     "a ray that is not in the parent's queue", "no such ray", where, at);
                continue;
            }
            if ((worker_.pushed[p] >> c & 1u) != 0) {
                fail(invariant::kNoDuplicate, child, ray, block_of(p),
                     "the ray is in the queue twice", "one entry", where, at);
                continue;
            }
            worker_.pushed[p] |= 1u << c;
            ++distinct;
            if ((allowed(p) >> c & 1u) == 0) {
                const bool overlapped = (worker_.expected[p].overlapped >> c & 1u) != 0;
                fail(invariant::kNothingExtra, child, ray, block_of(p),
                     overlapped ? "a ray that had to be culled: it enters beyond its nearest hit"
                                : "a ray that does not enter the child's box",
                     "no such ray", where, at);
            }
            check_order(child, ray, p, run_block, last_position);
        }
        check_required(c, child, count, distinct);
        worker_.tally.pushes += shown;
    }

    /// The children that a ray may be pushed to: under `immediate` all that it overlaps.
    std::uint32_t allowed(std::uint32_t p) const {
        return launch_.state.parameters.early_out == EarlyOut::immediate
                   ? worker_.expected[p].overlapped
                   : worker_.expected[p].required;
    }

    /// The entries of one block must be contiguous and in the order of the input.
    void check_order(std::uint32_t child, std::uint32_t ray, std::uint32_t p,
                     std::uint32_t& run_block, std::uint32_t& last_position) {
        const std::uint32_t block = p / launch_.per_block;
        if (block != run_block) {
            if (worker_.block_seen[block] != 0) {
                fail(invariant::kInputOrder, child, ray, block_of(p),
                     "a block's rays do not lie together", "one run a block", "several");
            }
            worker_.block_seen[block] = 1;
            run_block = block;
        } else if (p < last_position) {
            fail(invariant::kInputOrder, child, ray, block_of(p),
                 "a block's run is not in the order of its input",
                 fmt::format("behind input position {}", p),
                 fmt::format("behind {}", last_position));
        }
        last_position = p;
    }

    void check_required(std::uint32_t c, std::uint32_t child, std::uint32_t count,
                        std::uint32_t distinct) {
        const bool immediate = launch_.state.parameters.early_out == EarlyOut::immediate;
        std::uint32_t required = 0;
        for (std::uint32_t p = 0; p < worker_.pushed.size(); ++p) {
            const ExpectedChildren& expected = worker_.expected[p];
            required += expected.required >> c & 1u;
            if ((worker_.pushed[p] >> c & 1u) != 0) continue;
            if ((expected.required >> c & 1u) != 0) {
                fail(invariant::kRequiredPresent, child, entry(p), block_of(p),
                     "a ray that enters the child's box was not pushed to it",
                     fmt::format("the ray, which enters at {}", exact(expected.entry[c])),
                     "no such ray");
            } else if (immediate && (expected.overlapped >> c & 1u) != 0) {
                worker_.kept_out.push_back({entry(p), child, block_of(p), expected.entry[c]});
            }
        }
        const bool wrong = immediate ? count != distinct : count != required;
        if (wrong) {
            // Not bounded by kFailuresPerNode: it is one per child, and the same fault again.
            Failure failure = failure_at(launch_.stage, invariant::kCountEqualsPushes,
                                         "the child's count is not the number of rays pushed");
            failure.node = launch_.first_node + node_;
            failure.field = fmt::format("child_counts of node {}", child);
            failure.expected = std::to_string(immediate ? distinct : required);
            failure.found = std::to_string(count);
            worker_.failures.push_back(std::move(failure));
        }
    }

    /// Checks that rays in = pushed on, missed or culled.
    void check_conservation() {
        std::uint32_t pushed = 0;
        std::uint32_t missed = 0;
        std::uint32_t culled = 0;
        for (std::uint32_t p = 0; p < worker_.pushed.size(); ++p) {
            const ExpectedChildren& expected = worker_.expected[p];
            if (worker_.pushed[p] != 0) {
                ++pushed;
            } else if (expected.overlapped == 0) {
                ++missed;
            } else if (expected.required == 0) {
                ++culled;
            }
        }
        const auto in = static_cast<std::uint32_t>(worker_.pushed.size());
        worker_.tally.entries += in;
        worker_.tally.missed += missed;
        worker_.tally.culled += culled;
        if (pushed + missed + culled == in) return;
        Failure failure = failure_at(launch_.stage, invariant::kConservation,
                                     "rays were lost: neither pushed to a child, nor missed, nor "
                                     "culled");
        failure.node = launch_.first_node + node_;
        failure.field = "rays of the node";
        failure.expected = fmt::format("{} in", in);
        failure.found = fmt::format("{} pushed + {} missed + {} culled", pushed, missed, culled);
        worker_.failures.push_back(std::move(failure));
    }

    const Launch& launch_;
    std::uint32_t node_;
    Worker& worker_;
    NodeBoxes boxes_;
    std::size_t reported_ = 0;
};

/// Checks that a level reads the queue that the level before wrote, and that its ids are ray ids.
bool check_input_queue(CheckState& state, const Launch& launch) {
    const TraversalState& traversal = state.traversal;
    std::uint64_t total = 0;
    for (std::uint32_t node = 0; node < launch.counts.size(); ++node) {
        const std::uint32_t count = launch.counts[node];
        total += count;
        if (launch.queue.empty() && launch.stage.level == 0) continue;
        const std::size_t begin = launch.offsets[node];
        Failure failure = failure_at(launch.stage, invariant::kHandOver, "");
        failure.node = launch.first_node + node;
        if (begin + count > launch.queue.size()) {
            failure.sentence = "the node's queue reaches beyond the buffer";
            failure.field = "queue_offsets + node_counts";
            failure.expected = fmt::format("at most {}", launch.queue.size());
            failure.found = std::to_string(begin + count);
            state.add(std::move(failure));
            return false;
        }
        const bool known = traversal.running && node < traversal.node_counts.size() &&
                           node < traversal.queue_offsets.size();
        for (std::uint32_t p = 0; p < count; ++p) {
            const std::uint32_t ray = launch.queue[begin + p];
            const bool same =
                !known || (p < traversal.node_counts[node] &&
                           traversal.queue_offsets[node] + p < traversal.queue.size() &&
                           traversal.queue[traversal.queue_offsets[node] + p] == ray);
            if (same && ray < launch.ray_count) continue;
            failure.ray = ray;
            failure.field = fmt::format("queue[{}]", begin + p);
            failure.sentence = same ? "a queue entry is no ray id"
                                    : "the queue is not the one that the level before has written";
            failure.expected = same ? fmt::format("an id below {}", launch.ray_count)
                                    : fmt::format("what the parent pushed as entry {}", p);
            failure.found = std::to_string(ray);
            state.add(std::move(failure));
            return false;
        }
    }
    if (launch.stage.level != 0) return true;
    Failure failure =
        failure_at(launch.stage, invariant::kHandOver, "the root takes every ray once");
    if (total != launch.ray_count) {
        failure.field = "node_counts[0]";
        failure.expected = std::to_string(launch.ray_count);
        failure.found = std::to_string(total);
        state.add(std::move(failure));
        return false;
    }
    if (traversal.scanned && !traversal.node_counts.empty() &&
        traversal.node_counts.front() != launch.ray_count) {
        failure.sentence = "the scan read another number of rays than the root takes";
        failure.field = "node_counts[0]";
        failure.expected = std::to_string(launch.ray_count);
        failure.found = std::to_string(traversal.node_counts.front());
        state.add(std::move(failure));
        return false;
    }
    const auto offsets = launch.stage.get(buffers::queue_offsets);
    for (std::uint32_t i = 0; i < offsets.size(); ++i) {
        const std::uint32_t expected = i == 0 ? 0 : launch.ray_count;
        if (offsets[i] == expected) continue;
        failure.field = fmt::format("queue_offsets[{}]", i);
        failure.expected = std::to_string(expected);
        failure.found = std::to_string(offsets[i]);
        state.add(std::move(failure));
        return false;
    }
    return true;
}

}  // namespace

void remember_kept_out(CheckState& state, const StageView& stage,
                       const std::vector<KeptOutRay>& rays) {
    auto& kept_out = state.traversal.kept_out;
    kept_out.resize(stage.get(buffers::rays).size());
    for (const KeptOutRay& ray : rays) {
        auto& nearest = kept_out[ray.ray];
        // For equal entries the lower node: the report must not depend on the workers.
        if (ray.entry < nearest.entry ||
            (ray.entry == nearest.entry && stage.launch == nearest.launch &&
             ray.child < nearest.node)) {
            nearest = {ray.entry, stage.launch, stage.level, ray.child, ray.block};
        }
    }
}

void check_queues(CheckState& state, const StageView& stage) {
    const auto& begins = state.bvh.level_begins;
    if (stage.level == kNotApplicable || stage.level + 1 >= begins.size()) {
        state.add(failure_at(stage, invariant::kHandOver, "the BVH has no such level"));
        return;
    }
    const std::uint32_t nodes = begins[stage.level + 1] - begins[stage.level];
    const std::uint32_t children =
        stage.level + 2 < begins.size() ? begins[stage.level + 2] - begins[stage.level + 1] : 0u;
    const TraversalState& traversal = state.traversal;
    Launch launch{.stage = stage, .state = state};
    launch.rays = stage.get(buffers::rays);
    launch.ray_count = static_cast<std::uint32_t>(launch.rays.size());
    launch.first_node = begins[stage.level];
    launch.first_child = begins[stage.level + 1];
    launch.per_block = static_cast<std::uint32_t>(state.parameters.rays_per_block);
    launch.counts = expect_buffer(state, stage, buffers::node_counts, nodes);
    launch.queue = stage.get(buffers::queue);
    if (stage.level > 0) {
        launch.offsets = stage.get(buffers::queue_offsets);
        if (launch.offsets.size() < nodes) {
            launch.offsets = expect_buffer(state, stage, buffers::queue_offsets, nodes + 1);
        }
    }
    launch.child_queue = stage.get(buffers::child_queue);
    if (stage.level == 0) launch.queue = {};
    if (launch.counts.empty() || (stage.level > 0 && launch.offsets.empty())) return;
    if (!check_input_queue(state, launch)) return;

    launch.block_offsets = stage.get(buffers::block_offsets);
    if (launch.block_offsets.size() < nodes) launch.block_offsets = traversal.block_offsets;
    if (launch.block_offsets.size() < nodes) launch.block_offsets = {};
    if (state.parameters.early_out != EarlyOut::off) {
        launch.minimum = expect_buffer(state, stage, buffers::minimum, launch.ray_count);
        if (launch.minimum.empty() && launch.ray_count != 0) return;
    }
    if (children != 0) {
        launch.child_counts = expect_buffer(state, stage, buffers::child_counts, children);
        launch.child_offsets = expect_buffer(state, stage, buffers::child_offsets, children + 1);
        if (launch.child_counts.empty() || launch.child_offsets.empty()) return;
        if (launch.child_queue.size() < launch.child_offsets.back()) {
            expect_buffer(state, stage, buffers::child_queue, launch.child_offsets.back());
            return;
        }
        for (std::uint32_t child = 0; child < children; ++child) {
            if (launch.child_offsets[child] > launch.child_offsets[child + 1]) return;  // scan's
        }
    }

    tbb::enumerable_thread_specific<Worker> workers([&] {
        Worker worker;
        worker.position.assign(launch.ray_count, kNone);
        return worker;
    });
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, nodes), [&](const auto& range) {
        Worker& worker = workers.local();
        for (std::uint32_t node = range.begin(); node != range.end(); ++node) {
            // A subtree pushes no rays: check_leaves judges their hits.
            if (children == 0 || is_leaf(state.bvh.node_refs[launch.first_node + node])) continue;
            NodeCheck(launch, node, worker).run();
        }
    });
    std::vector<Failure> failures;
    for (const Worker& worker : workers) {
        failures.insert(failures.end(), worker.failures.begin(), worker.failures.end());
        state.counts.entries += worker.tally.entries;
        state.counts.pushes += worker.tally.pushes;
        state.counts.missed += worker.tally.missed;
        state.counts.culled += worker.tally.culled;
        if (!worker.kept_out.empty()) remember_kept_out(state, stage, worker.kept_out);
    }
    state.add_sorted(std::move(failures));
}

void begin_traversal(CheckState& state, const StageView& stage) {
    TraversalState& traversal = state.traversal;
    forget_traversal(state);
    traversal = TraversalState{};
    traversal.running = true;
    traversal.failures_before = state.counts.failures;
    traversal.kept_before = state.failures.size();
    const bool any = stage.light != kNotApplicable
                         ? state.parameters.shadow_query == ShadowQuery::any
                         : stage.bounce == kNotApplicable && state.settings.trace_asks_any;
    traversal.asks_any = any && state.parameters.early_out != EarlyOut::off;
}

void follow_level(CheckState& state, const StageView& stage) {
    TraversalState& traversal = state.traversal;
    if (stage.level == 0 || traversal.rays.empty()) {
        traversal.rays = copy_of(stage.get(buffers::rays));
        const std::size_t n = traversal.rays.size();
        traversal.hit_counts.assign(n, 0);
        traversal.hit_sums.assign(n, 0);
        traversal.packed.assign(n, kNoPackedHit);
        traversal.best.assign(n, {kInfinity, kNone});
        traversal.minimum.assign(n, kInfinity);
    }
    traversal.level = stage.level;
    traversal.scanned = false;
    traversal.node_counts = copy_of(stage.get(buffers::child_counts));
    traversal.queue_offsets = copy_of(stage.get(buffers::child_offsets));
    traversal.queue = copy_of(stage.get(buffers::child_queue));
    traversal.pairs = copy_of(stage.get(buffers::child_pairs));

    const auto note = [&](std::size_t ray, float t, std::uint32_t primitive) {
        HitCandidate& best = traversal.best[ray];
        if (t < best.t || (t == best.t && primitive < best.primitive)) best = {t, primitive};
    };
    const std::size_t n = traversal.rays.size();
    const auto packed = stage.get(buffers::packed_hits);
    for (std::size_t ray = 0; ray < packed.size() && ray < n; ++ray) {
        if (packed[ray] == kNoPackedHit || packed[ray] == traversal.packed[ray]) continue;
        traversal.packed[ray] = packed[ray];
        note(ray, std::bit_cast<float>(static_cast<std::uint32_t>(packed[ray] >> 32)),
             static_cast<std::uint32_t>(packed[ray]));
    }
    const auto counts = stage.get(buffers::hit_counts);
    const auto hits = stage.get(buffers::hits);
    const std::size_t capacity = n == 0 ? 0 : hits.size() / n;
    for (std::size_t ray = 0; ray < counts.size() && ray < n; ++ray) {
        const std::size_t end = counts[ray] < capacity ? counts[ray] : capacity;
        for (std::size_t slot = traversal.hit_counts[ray]; slot < end; ++slot) {
            note(ray, hits[ray * capacity + slot].t, hits[ray * capacity + slot].primitive);
        }
        traversal.hit_counts[ray] = counts[ray];
        traversal.hit_sums[ray] = sum_of_hits(hits.subspan(ray * capacity, end));
    }
}

void follow_minimum(CheckState& state, const StageView& stage) {
    if (state.parameters.early_out == EarlyOut::off) return;
    const auto minimum = stage.get(buffers::minimum);
    if (minimum.size() == state.traversal.rays.size()) state.traversal.minimum = copy_of(minimum);
}

}  // namespace scotty::verify
