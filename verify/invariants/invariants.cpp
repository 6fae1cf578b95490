#include "verify/invariants/invariants.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "verify/invariants/check_state.h"

namespace scotty::verify {

using reference::StageKind;
using reference::StageView;

InvariantCounts& InvariantCounts::operator+=(const InvariantCounts& other) {
    stages += other.stages;
    entries += other.entries;
    pushes += other.pushes;
    missed += other.missed;
    culled += other.culled;
    leaf_hits += other.leaf_hits;
    non_finite += other.non_finite;
    failures += other.failures;
    retries += other.retries;
    return *this;
}

InvariantChecker::InvariantChecker(const reference::Scene& scene, const reference::WideBvh& bvh,
                                   const reference::PipelineParameters& parameters,
                                   InvariantSettings settings)
    : state_(new State{scene, bvh, parameters, std::move(settings), {}, {}, {}, {}, {}, {}}) {}

InvariantChecker::~InvariantChecker() = default;

const std::vector<Failure>& InvariantChecker::failures() const { return state_->failures; }
const InvariantCounts& InvariantChecker::counts() const { return state_->counts; }

void InvariantChecker::State::add(Failure failure) {
    ++counts.failures;
    if (failures.size() >= settings.max_failures) return;
    if (failure.shown_at != nullptr && settings.written_by) {
        failure.written_by = settings.written_by(failure.shown_at);
    }
    failures.push_back(std::move(failure));
}

void InvariantChecker::State::add_sorted(std::vector<Failure> found) {
    // Failures that name a ray say more than those that only report a wrong sum.
    const auto key = [](const Failure& f) {
        return std::make_tuple(f.node, f.ray == reference::kNotApplicable, f.block, f.ray);
    };
    std::stable_sort(found.begin(), found.end(),
                     [&](const Failure& a, const Failure& b) { return key(a) < key(b); });
    for (Failure& failure : found) add(std::move(failure));
}

Failure failure_at(const StageView& stage, const char* invariant, std::string sentence) {
    Failure failure;
    failure.invariant = invariant;
    failure.stage = stage.name;
    failure.launch = stage.launch;
    failure.level = stage.level;
    failure.sentence = std::move(sentence);
    return failure;
}

void InvariantChecker::on_stage(const StageView& stage) {
    State& state = *state_;
    bool judged = stage_matches(state.settings.stage_pattern, stage.name);
    const bool starts =
        stage.level == 0 &&
        (stage.kind == StageKind::scan_counts ||
         (stage.kind == StageKind::intersect_root &&
          !(state.traversal.running && state.traversal.scanned && state.traversal.level == 0)));
    if (starts) begin_traversal(state, stage);
    if (judged) {
        ++state.counts.stages;
        check_finite(state, stage);
    }
    // What was made of wrong inputs is not this stage's fault.
    if (judged) judged = check_hand_over(state, stage);
    const bool recomputed = judged && state.settings.recompute_shading;
    switch (stage.kind) {
        case StageKind::scan_counts:
            if (judged) check_scan(state, stage);
            follow_scan(state, stage);
            break;
        case StageKind::intersect_root:
        case StageKind::intersect:
            if (judged) {
                if (state.parameters.queues == reference::QueueKind::pairs) {
                    check_pairs(state, stage);
                } else {
                    check_queues(state, stage);
                }
                check_leaves(state, stage);
            }
            follow_level(state, stage);
            if (judged) check_minimum(state, stage);
            follow_minimum(state, stage);
            break;
        case StageKind::publish_minimum:
            if (judged) check_minimum(state, stage);
            follow_minimum(state, stage);
            break;
        case StageKind::merge_intersections:
            if (judged) check_merge(state, stage);
            follow_shading(state, stage);
            state.traversal.running = false;
            break;
        case StageKind::primary_rays:
            if (judged) check_primary_rays(state, stage);
            if (recomputed) check_primary_paths(state, stage);
            follow_shading(state, stage);
            break;
        case StageKind::direct_light_rays:
            if (judged) check_direct_light_rays(state, stage);
            if (recomputed) check_light_paths(state, stage);
            follow_shading(state, stage);
            break;
        case StageKind::resolve_light:
            if (judged) check_resolve_light(state, stage);
            follow_shading(state, stage);
            break;
        case StageKind::scene_rays:
            if (judged) check_scene_rays(state, stage);
            if (recomputed) check_scattered_paths(state, stage);
            follow_shading(state, stage);
            break;
        case StageKind::reconstruct_image:
            if (judged) check_image(state, stage);
            break;
        case StageKind::filter:
            if (judged) check_filter(state, stage);
            break;
    }
    follow_hand_over(state, stage);
}

void InvariantChecker::on_retry(std::string_view, std::string_view) {
    State& state = *state_;
    ++state.counts.retries;
    if (!state.traversal.running) return;
    // The abandoned attempt does not count, right or wrong.
    state.counts.failures = state.traversal.failures_before;
    state.failures.resize(std::min(state.failures.size(), state.traversal.kept_before));
    state.traversal.running = false;
}

}  // namespace scotty::verify
