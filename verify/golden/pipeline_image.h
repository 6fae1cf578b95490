/// A pipeline's picture with its noise, measured while it renders.
#pragma once

#include <string>

#include "reference/contract/stage_observer.h"
#include "reference/truth/sample_sums.h"
#include "verify/backends/backend.h"
#include "verify/capture/pipeline_input.h"
#include "verify/images/measured_image.h"

namespace scotty::verify {

/// Means and their variances, in double precision. Requires two samples.
MeasuredImage measured(const reference::SampleSums& sums);

/// Adds up every path's radiance as it enters image reconstruction.
class RadianceMeter : public reference::StageObserver {
 public:
    explicit RadianceMeter(const reference::PipelineParameters& parameters);
    bool wants(reference::StageKind kind) const override;
    void on_stage(const reference::StageView& stage) override;

    /// Throws internal where not every pixel has had each of its samples.
    const reference::SampleSums& sums() const;

 private:
    std::uint64_t paths_;
    std::uint64_t added_ = 0;
    reference::SampleSums sums_;
};

struct PipelineImage {
    MeasuredImage image;  ///< of the paths' radiance
    /// Empty where the picture that the pipeline handed out is the mean of its paths, but for
    /// float32 rounding; else one sentence with the first pixel where it is not.
    std::string reconstruction_fault;
};

/// Renders. The input's filter must be none.
PipelineImage measure_pipeline(const Backend& backend, const PipelineInput& input);

}  // namespace scotty::verify
