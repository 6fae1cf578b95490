/// Checks after every kernel launch that it wrote what it had to write.
///
/// The checker is an observer. It recomputes the expected values from the launch's inputs with the
/// reference numerics in plain loops, and uses nothing of the scheduling under test.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

struct InvariantSettings {
    /// Only stages with matching names are judged (stage_matches); all are followed.
    std::string stage_pattern;
    /// Pipeline::trace() names no query; true if it was called for any hit.
    bool trace_asks_any = false;
    /// Like Backend::written_by: says who wrote the value that a failure points at.
    std::function<std::string(const void*)> written_by{};
    /// Off if shading may use other arithmetic than the exact one.
    bool recompute_shading = true;
    std::size_t max_failures = 20;  ///< kept; the rest is counted
};

/// What was judged. A judgement over nothing is not a pass: see `stages`.
struct InvariantCounts {
    std::uint64_t stages = 0;   ///< judged
    std::uint64_t entries = 0;  ///< rays in the queues of inner nodes
    std::uint64_t pushes = 0;   ///< queue entries written
    std::uint64_t missed = 0;   ///< rays in a node that enter no child
    std::uint64_t culled = 0;   ///< rays in a node that enter only children that are too far away
    std::uint64_t leaf_hits = 0;
    std::uint64_t non_finite = 0;  ///< values; each is a failure
    std::uint64_t failures = 0;
    std::uint64_t retries = 0;  ///< traversals run again because a buffer had to grow

    InvariantCounts& operator+=(const InvariantCounts& other);
};

class InvariantChecker : public reference::StageObserver {
 public:
    /// All arguments are borrowed for the checker's life.
    InvariantChecker(const reference::Scene& scene, const reference::WideBvh& bvh,
                     const reference::PipelineParameters& parameters,
                     InvariantSettings settings = {});
    ~InvariantChecker() override;

    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

    /// In launch order, and within a launch by node; a launch's non-finite values come first.
    const std::vector<Failure>& failures() const;
    const InvariantCounts& counts() const;

    struct State;  ///< defined for the checks only (check_state.h)

 private:
    std::unique_ptr<State> state_;
};

}  // namespace scotty::verify
