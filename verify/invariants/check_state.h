/// Shared by the checks of the single stages (check_*.cpp): what they have seen so far.
#pragma once

#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "verify/base/same_bits.h"
#include "verify/invariants/invariants.h"

namespace scotty::verify {

/// The state of the running traversal, by ray id unless stated otherwise.
struct TraversalState {
    bool running = false;
    bool scanned = false;   ///< scan_counts of this level has been seen
    bool asks_any = false;  ///< early-out on, and the query asks only "is anything hit"
    std::uint32_t level = 0;
    std::uint64_t failures_before = 0;  ///< counts.failures when it began, for on_retry
    std::size_t kept_before = 0;        ///< failures kept when it began
    std::vector<reference::Ray> rays;

    // By node, from the level before.
    std::vector<std::uint32_t> node_counts;
    std::vector<std::uint32_t> queue_offsets;
    std::vector<std::uint32_t> queue;
    std::vector<reference::NodeRay> pairs;  ///< from the level before
    // This level's scan.
    std::vector<std::uint32_t> block_offsets;
    std::vector<std::uint32_t> child_offsets;

    std::vector<std::uint32_t> hit_counts;
    std::vector<std::uint64_t> hit_sums;  ///< sum_of_hits of all hits gathered so far
    std::vector<std::uint64_t> packed;
    std::vector<reference::HitCandidate> best;  ///< closest of all hits appended so far
    std::vector<float> minimum;                 ///< as last seen

    /// Early-out `immediate`: the nearest box that a ray was kept out of, and its place.
    struct KeptOut {
        float entry = reference::kInfinity;
        std::uint32_t launch = reference::kNotApplicable;
        std::uint32_t level = reference::kNotApplicable;
        std::uint32_t node = reference::kNotApplicable;
        std::uint32_t block = reference::kNotApplicable;
    };
    std::vector<KeptOut> kept_out;
};

/// The state of the paths in flight, by ray id.
struct PathState {
    std::vector<reference::Ray> rays, shadow_rays;
    std::vector<reference::Hit> path_hits, shadow_hits;
    std::vector<reference::Vec3> radiance, potential, throughput;
    std::vector<std::uint32_t> pixel, sample, depth, flags;
};

/// The image's state, by pixel: the number of generated samples, and the sum so far.
struct ImageState {
    std::vector<std::uint32_t> samples;
    std::vector<std::uint32_t> summed;
    std::vector<reference::Vec3> sum;
    std::vector<reference::Vec3> deviations;  ///< squared, from the mean so far
};

/// What each buffer held when it was last written, for the stages that read it.
struct HandOver {
    /// The buffer as its writer calls it, its level (kNotApplicable where it has none), and whether
    /// it is of shadow rays.
    using Key = std::tuple<const reference::BufferInfo*, std::uint32_t, bool>;
    struct Written {
        std::vector<std::byte> bytes;
        std::string stage;
        bool was_read = false;  ///< nobody wrote it: what `stage`, the first to read it, has seen
    };
    std::map<Key, Written> written;
};

struct InvariantChecker::State {
    const reference::Scene& scene;
    const reference::WideBvh& bvh;
    const reference::PipelineParameters& parameters;
    InvariantSettings settings;

    InvariantCounts counts;
    std::vector<Failure> failures;
    TraversalState traversal;
    PathState paths;
    ImageState image;
    HandOver handed_over;

    void add(Failure failure);
    /// Sorts by node, then by how specific the invariant is, then by ray, and adds them.
    void add_sorted(std::vector<Failure> found);
};

/// A failure with the stage's place filled in.
Failure failure_at(const reference::StageView& stage, const char* invariant, std::string sentence);

using CheckState = InvariantChecker::State;

/// A number that changes when any of the hits does; in any order.
std::uint64_t sum_of_hits(std::span<const reference::HitCandidate> hits);

template <class T>
std::vector<T> copy_of(std::span<const T> values) {
    return {values.begin(), values.end()};
}

/// The buffer, or nothing and a failure if it is missing or has another size.
template <class T>
std::span<const T> expect_buffer(CheckState& state, const reference::StageView& stage,
                                 const reference::Buffer<T>& buffer, std::size_t size) {
    const std::span<const T> values = stage.get(buffer);
    if (values.size() == size) return values;
    Failure failure = failure_at(stage, invariant::kHandOver,
                                 "a buffer is missing or has another size than the contract says");
    failure.field = std::string(buffer.name);
    failure.expected = std::to_string(size) + " elements";
    failure.found = std::to_string(values.size());
    state.add(std::move(failure));
    return {};
}

/// Returns true if `seen` holds the bytes of `expected`; else reports the first difference.
template <class T, class Describe>
bool expect_same(CheckState& state, const reference::StageView& stage, const char* tag,
                 std::string_view field, std::span<const T> expected, std::span<const T> seen,
                 bool by_ray, const char* sentence, const Describe& describe) {
    for (std::size_t i = 0; i < expected.size() && i < seen.size(); ++i) {
        if (same_bits(expected[i], seen[i])) continue;
        Failure failure = failure_at(stage, tag, sentence);
        failure.field = std::string(field) + "[" + std::to_string(i) + "]";
        if (by_ray) failure.ray = static_cast<std::uint32_t>(i);
        failure.expected = describe(expected[i]);
        failure.found = describe(seen[i]);
        state.add(std::move(failure));
        return false;
    }
    return true;
}

// One function per stage kind. Each reads only the stage and the state of stages before.
void check_scan(CheckState& state, const reference::StageView& stage);
void check_queues(CheckState& state, const reference::StageView& stage);
/// The same where a level has one queue of pairs.
void check_pairs(CheckState& state, const reference::StageView& stage);
void check_leaves(CheckState& state, const reference::StageView& stage);
void check_minimum(CheckState& state, const reference::StageView& stage);
void check_merge(CheckState& state, const reference::StageView& stage);
void check_primary_rays(CheckState& state, const reference::StageView& stage);
void check_direct_light_rays(CheckState& state, const reference::StageView& stage);
void check_resolve_light(CheckState& state, const reference::StageView& stage);
void check_scene_rays(CheckState& state, const reference::StageView& stage);
void check_image(CheckState& state, const reference::StageView& stage);
// These recompute the same stages' results.
void check_primary_paths(CheckState& state, const reference::StageView& stage);
void check_light_paths(CheckState& state, const reference::StageView& stage);
void check_scattered_paths(CheckState& state, const reference::StageView& stage);
void check_filter(CheckState& state, const reference::StageView& stage);
/// Checks that every value that has to be finite is.
void check_finite(CheckState& state, const reference::StageView& stage);
/// Checks that the stage reads what stages before it have written; false where it does not.
bool check_hand_over(CheckState& state, const reference::StageView& stage);

// These record what later stages are checked against; they run whether or not the stage is judged.
void begin_traversal(CheckState& state, const reference::StageView& stage);
void follow_scan(CheckState& state, const reference::StageView& stage);
void follow_level(CheckState& state, const reference::StageView& stage);
void follow_minimum(CheckState& state, const reference::StageView& stage);
void follow_shading(CheckState& state, const reference::StageView& stage);
void follow_hand_over(CheckState& state, const reference::StageView& stage);
/// A ray kept out of a box although it overlaps it, under early-out `immediate`: keeps the nearest
/// such box of each ray, and merge judges by the final hit.
struct KeptOutRay {
    std::uint32_t ray, child, block;
    float entry;
};
void remember_kept_out(CheckState& state, const reference::StageView& stage,
                       const std::vector<KeptOutRay>& rays);
/// Before a traversal, and before one that is run again.
void forget_traversal(CheckState& state);

}  // namespace scotty::verify
