/// One configuration under several schedules: whatever the contract calls determined is the same in
/// all of them, and a schedule run twice is the same in every byte.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

/// An output of a launch, as two hashes.
struct StageHash {
    std::string stage, buffer;
    std::uint32_t launch = 0;
    /// Of what no schedule may change: the canonical form (canonical.h); of shadow rays that only
    /// ask, under early-out `immediate`, whether they hit. Empty where nothing is determined: what
    /// traversal gathers under `immediate`.
    std::string determined;
    std::string bytes;  ///< of the bytes in use, in the order in which they lie
};

/// Hashes all that a run shows. What a retry has made void is left out.
class StageHasher : public reference::StageObserver {
 public:
    explicit StageHasher(const reference::PipelineParameters& parameters)
        : parameters_(parameters) {}
    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

    const std::vector<StageHash>& hashes() const { return hashes_; }

 private:
    const reference::PipelineParameters& parameters_;
    std::vector<StageHash> hashes_;
    std::size_t traversal_begin_ = 0;  ///< of the hashes, where the last traversal begins
};

/// Renders under one schedule, shown to the observer.
using ScheduledRender =
    std::function<void(const emulation::Schedule& schedule, reference::StageObserver& observer)>;

/// Runs every schedule; the first and the last one twice. At most one failure a schedule, naming
/// the first stage and buffer that differ: `same-in-every-schedule` against the first schedule,
/// `stray-nondeterminism` where the second run of one differs from its first.
std::vector<Failure> check_schedules(const std::vector<emulation::Schedule>& schedules,
                                     const reference::PipelineParameters& parameters,
                                     const ScheduledRender& render);

}  // namespace scotty::verify
