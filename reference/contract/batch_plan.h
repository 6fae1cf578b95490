/// How a render cuts the image into batches of at most `batch_rays` paths.
///
/// Passes come one after the other; a pass takes the image in bands of pixels; the samples of a
/// band that do not fit one batch follow in further batches. A pixel's samples are therefore
/// rendered in their order, whatever the parameters.
#pragma once

#include <cstdint>

#include "reference/contract/launch_record.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/views.h"

namespace scotty::reference {

class BatchPlan {
 public:
    /// The parameters are valid.
    explicit BatchPlan(const PipelineParameters& parameters);

    std::uint64_t size() const;
    /// Requires batch < size().
    BatchView operator[](std::uint64_t batch) const;

 private:
    std::uint64_t rounds_of(std::uint64_t samples) const;

    std::uint32_t pixels_;
    std::uint32_t spp_;
    std::uint32_t pass_samples_;
    std::uint32_t samples_;  ///< of a batch, at most
    std::uint32_t at_once_;  ///< pixels of a batch, at most
    std::uint64_t bands_;
};

/// Calls f(place, batch) for the batches of a render, in their order, and announce(done, count)
/// before each and after the last.
template <class Announce, class F>
void for_each_batch(const PipelineParameters& parameters, const Announce& announce, const F& f) {
    const BatchPlan plan(parameters);
    StagePlace place;
    place.several_batches = plan.size() > 1;
    for (; place.batch < plan.size(); ++place.batch) {
        announce(place.batch, plan.size());
        f(place, plan[place.batch]);
    }
    announce(plan.size(), plan.size());
}

}  // namespace scotty::reference
