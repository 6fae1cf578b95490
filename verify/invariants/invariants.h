/// Checks after every kernel launch that what it wrote is what it had to write.
///
/// An observer. What is expected is recomputed from the launch's inputs with the reference numerics
/// in plain loops: nothing of the scheduling under test is used.
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
    /// Only stages of such a name are judged (stage_matches); all are followed.
    std::string stage_pattern;
    /// Pipeline::trace() names no query: true where it was called for any hit.
    bool trace_asks_any = false;
    /// As Backend::written_by: who wrote what a failure points at.
    std::function<std::string(const void*)> written_by{};
    /// Off where shading may be computed by other arithmetic than the exact one.
    bool recompute_shading = true;
    std::size_t max_failures = 20;  ///< kept; the rest is counted
};

/// What was looked at. A judgement over nothing is not a pass: see `stages`.
struct InvariantCounts {
    std::uint64_t stages = 0;   ///< judged
    std::uint64_t entries = 0;  ///< rays in the queues of inner nodes
    std::uint64_t pushes = 0;   ///< queue entries written
    std::uint64_t missed = 0;   ///< rays in a node that enter no child
    std::uint64_t culled = 0;   ///< rays in a node that enter children, all of them too far away
    std::uint64_t leaf_hits = 0;
    std::uint64_t non_finite = 0;  ///< values; each is a failure
    std::uint64_t failures = 0;
    std::uint64_t retries = 0;  ///< traversals run again because a buffer had to grow
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

    /// In launch order, within a launch by node; non-finite values of a launch come first.
    const std::vector<Failure>& failures() const;
    const InvariantCounts& counts() const;

    struct State;  ///< defined for the checks alone (check_state.h)

 private:
    std::unique_ptr<State> state_;
};

}  // namespace scotty::verify
