/// One configuration under several schedules: everything that the contract calls determined must be
/// the same in all of them, and a schedule run twice must be the same in every byte.
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
    /// The hash of what no schedule may change: the canonical form (canonical.h); for shadow rays
    /// that only ask, under early-out `immediate`, whether they hit. Empty if nothing is
    /// determined, as for what traversal gathers under `immediate`.
    std::string determined;
    std::string bytes;  ///< of the bytes in use, in their order in memory
};

/// Hashes everything that a run shows. Stages that a retry has made void are left out.
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
    std::size_t traversal_begin_ = 0;  ///< the index of the last traversal's first hash
};

/// Renders under one schedule, with an observer.
using ScheduledRender =
    std::function<void(const emulation::Schedule& schedule, reference::StageObserver& observer)>;

/// Runs every schedule; the first and the last one twice. There is at most one failure per
/// schedule, which names the first stage and buffer that differ: `same-in-every-schedule` from the
/// first schedule, `stray-nondeterminism` if the second run of one differs from its first.
std::vector<Failure> check_schedules(const std::vector<emulation::Schedule>& schedules,
                                     const reference::PipelineParameters& parameters,
                                     const ScheduledRender& render);

}  // namespace scotty::verify
