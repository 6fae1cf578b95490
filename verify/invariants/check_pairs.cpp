/// intersect with queues of pairs: the pairs that a level has appended for the next.
///
/// The expected set is recomputed pair by pair with the reference box test: each inner child that a
/// ray enters from its node, no later than its limit, and no other. The order is free. Leaves are
/// tested in the launch that finds them: check_leaves judges their hits.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "verify/invariants/check_state.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records

namespace {

/// A broken kernel breaks thousands of pairs; at most this many failures are written out.
constexpr std::size_t kFailures = 64;

std::uint64_t key_of(const NodeRay& pair) { return std::uint64_t{pair.node} << 32 | pair.ray; }

/// A pair that may be in the next level's queue.
struct ExpectedPair {
    std::uint64_t key;     ///< inner node << 32 | ray
    std::uint32_t child;   ///< the node's id
    std::uint32_t parent;  ///< id of the node that the ray comes from
    std::uint32_t block;
    float entry;
    bool required;  ///< else it may be left out, under `immediate`, or must be
};

class PairCheck {
 public:
    PairCheck(CheckState& state, const StageView& stage)
        : state_(state),
          stage_(stage),
          rays_(stage.get(buffers::rays)),
          pairs_(stage.get(buffers::pairs)),
          child_pairs_(stage.get(buffers::child_pairs)),
          begins_(inner_begins(state.bvh)),
          ids_(ids_of_inner(state.bvh)) {}

    void run() {
        if (state_.parameters.early_out != EarlyOut::off) {
            minimum_ = expect_buffer(state_, stage_, buffers::minimum, rays_.size());
            if (minimum_.empty() && !rays_.empty()) return;
        }
        if (stage_.level != 0 && !check_input()) return;
        if (!state_.bvh.is_level_of_subtrees(stage_.level)) find_expected();
        compare();
        state_.counts.pushes += child_pairs_.size();
        state_.add_sorted(std::move(failures_));
    }

 private:
    static std::vector<std::uint32_t> ids_of_inner(const WideBvh& bvh) {
        std::vector<std::uint32_t> ids(bvh.inner_count(), kNone);
        for (std::uint32_t id = 0; id < bvh.node_count(); ++id) {
            if (!is_leaf(bvh.node_refs[id])) ids[bvh.node_refs[id]] = id;
        }
        return ids;
    }

    bool immediate() const { return state_.parameters.early_out == EarlyOut::immediate; }

    Failure failure_of(const char* tag, std::string sentence, std::string expected,
                       std::string found) const {
        Failure failure = failure_at(stage_, tag, std::move(sentence));
        failure.field = buffers::child_pairs.name;
        failure.expected = std::move(expected);
        failure.found = std::move(found);
        return failure;
    }
    void add(Failure failure) {
        if (failures_.size() < kFailures) failures_.push_back(std::move(failure));
    }

    /// Whether it is a ray in a node of the level whose inner nodes begin at begins_[level].
    bool is_of_level(const NodeRay& pair, std::uint32_t level) const {
        return pair.ray < rays_.size() && level + 1 < begins_.size() &&
               pair.node >= begins_[level] && pair.node < begins_[level + 1];
    }

    /// Checks that a level reads pairs of its own nodes.
    bool check_input() {
        for (std::size_t p = 0; p < pairs_.size(); ++p) {
            if (is_of_level(pairs_[p], stage_.level)) continue;
            Failure failure =
                failure_at(stage_, invariant::kHandOver, "not a ray in an inner node of the level");
            failure.ray = pairs_[p].ray;
            failure.field = fmt::format("pairs[{}]", p);
            failure.expected =
                fmt::format("an inner node from {} to {} and a ray below {}", begins_[stage_.level],
                            begins_[stage_.level + 1], rays_.size());
            failure.found = fmt::format("inner node {}, ray {}", pairs_[p].node, pairs_[p].ray);
            state_.add(std::move(failure));
            return false;
        }
        return true;
    }

    void find_expected() {
        const WideBvh& bvh = state_.bvh;
        const NodeBoxes root = boxes_of(bvh, 0);
        const std::size_t count = stage_.level == 0 ? rays_.size() : pairs_.size();
        NodeBoxes boxes = root;
        std::uint32_t of = 0;  // whose boxes they are
        std::uint64_t missed = 0;
        std::uint64_t culled = 0;
        for (std::size_t p = 0; p < count; ++p) {
            const NodeRay pair =
                stage_.level == 0 ? NodeRay{0, static_cast<std::uint32_t>(p)} : pairs_[p];
            if (pair.node != of) boxes = boxes_of(bvh, of = pair.node);
            const float limit = minimum_.empty() ? kInfinity : minimum_[pair.ray];
            const ExpectedChildren children = expected_pairs(boxes, root, rays_[pair.ray], limit);
            missed += children.overlapped == 0 ? 1 : 0;
            culled += children.overlapped != 0 && children.required == 0 ? 1 : 0;
            for (std::uint32_t c = 0; c < boxes.width; ++c) {
                if ((children.overlapped >> c & 1u) == 0) continue;
                const std::uint32_t ref = bvh.node_refs[boxes.child[c]];
                if (is_leaf(ref)) continue;
                expected_.push_back(
                    {key_of({ref, pair.ray}), boxes.child[c], ids_[pair.node],
                     static_cast<std::uint32_t>(
                         p / static_cast<std::size_t>(state_.parameters.rays_per_block)),
                     children.entry[c], (children.required >> c & 1u) != 0});
            }
        }
        state_.counts.entries += count;
        state_.counts.missed += missed;
        state_.counts.culled += culled;
        std::sort(expected_.begin(), expected_.end(),
                  [](const ExpectedPair& a, const ExpectedPair& b) { return a.key < b.key; });
    }

    void compare() {
        std::vector<std::uint64_t> found;  // sorted keys of what is a pair of the next level
        for (const NodeRay& pair : child_pairs_) {
            if (is_of_level(pair, stage_.level + 1)) {
                found.push_back(key_of(pair));
                continue;
            }
            const bool written = pair.ray < rays_.size() && pair.node < ids_.size();
            const auto slot = static_cast<std::size_t>(&pair - child_pairs_.data());
            Failure failure = failure_of(
                written ? invariant::kNothingExtra : invariant::kSlotWrittenOnce,
                written ? "a pair whose node is not of the next level"
                        : "a reserved slot holds no pair: it was never written",
                written ? "no such pair" : "an inner node of the next level and a ray",
                fmt::format("inner node {}, ray {} in slot {}", pair.node, pair.ray, slot));
            failure.ray = pair.ray;
            failure.shown_at = &pair;
            add(std::move(failure));
        }
        std::sort(found.begin(), found.end());
        std::vector<KeptOutRay> kept_out;
        auto next = found.begin();
        for (const ExpectedPair& expected : expected_) {
            for (; next != found.end() && *next < expected.key; ++next) add_extra(*next);
            std::size_t times = 0;
            for (; next != found.end() && *next == expected.key; ++next) ++times;
            judge(expected, times, kept_out);
        }
        for (; next != found.end(); ++next) add_extra(*next);
        if (!kept_out.empty()) remember_kept_out(state_, stage_, kept_out);
    }

    void add_extra(std::uint64_t key) {
        const auto ray = static_cast<std::uint32_t>(key);
        const std::uint32_t child = ids_[key >> 32];
        Failure failure =
            failure_of(invariant::kNothingExtra, "a pair that no ray of this level enters",
                       "no such pair", fmt::format("node {}, ray {}", child, ray));
        failure.node = state_.bvh.parents[child];
        failure.ray = ray;
        add(std::move(failure));
    }

    void judge(const ExpectedPair& expected, std::size_t times, std::vector<KeptOutRay>& kept_out) {
        const auto ray = static_cast<std::uint32_t>(expected.key);
        const auto fail = [&](const char* tag, const char* sentence, std::string wanted,
                              std::string seen) {
            Failure failure = failure_of(tag, sentence, std::move(wanted), std::move(seen));
            failure.node = expected.parent;
            failure.block = expected.block;
            failure.ray = ray;
            add(std::move(failure));
        };
        const std::string pair = failures_.size() < kFailures
                                     ? fmt::format("node {}, ray {}", expected.child, ray)
                                     : std::string();
        if (times > 1) {
            fail(invariant::kNoDuplicate, "the pair is in the queue twice", "one entry",
                 fmt::format("{} of {}", times, pair));
        } else if (times == 1 && !expected.required && !immediate()) {
            fail(invariant::kNothingExtra,
                 "a ray that had to be culled: it enters beyond its nearest hit", "no such pair",
                 pair);
        } else if (times == 0 && expected.required) {
            fail(invariant::kRequiredPresent,
                 "a ray that enters the child's box was not pushed to it",
                 fmt::format("{}, which enters at {}", pair, exact(expected.entry)),
                 "no such pair");
        } else if (times == 0 && immediate()) {
            kept_out.push_back({ray, expected.child, expected.block, expected.entry});
        }
    }

    CheckState& state_;
    const StageView& stage_;
    std::span<const Ray> rays_;
    std::span<const NodeRay> pairs_, child_pairs_;
    std::span<const float> minimum_{};
    std::vector<std::uint32_t> begins_;
    std::vector<std::uint32_t> ids_;  ///< by inner node: its id
    std::vector<ExpectedPair> expected_;
    std::vector<Failure> failures_;
};

}  // namespace

void check_pairs(CheckState& state, const StageView& stage) {
    if (stage.level == kNotApplicable || stage.level >= state.bvh.level_count()) {
        state.add(failure_at(stage, invariant::kHandOver, "the BVH has no such level"));
        return;
    }
    PairCheck(state, stage).run();
}

}  // namespace scotty::verify
