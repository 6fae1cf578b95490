#include "reference/contract/batch_plan.h"

#include <algorithm>

namespace scotty::reference {

BatchPlan::BatchPlan(const PipelineParameters& p)
    : pixels_(p.image_width * p.image_height),
      spp_(p.spp),
      pass_samples_(samples_of_pass(p)),
      samples_(std::min(pass_samples_, p.batch_rays)),
      at_once_(std::max(1u, std::min(pixels_, p.batch_rays / samples_))),
      bands_((pixels_ + std::uint64_t{at_once_} - 1) / at_once_) {}

std::uint64_t BatchPlan::rounds_of(std::uint64_t samples) const {
    return (samples + samples_ - 1) / samples_;
}

std::uint64_t BatchPlan::size() const {
    return bands_ *
           (spp_ / pass_samples_ * rounds_of(pass_samples_) + rounds_of(spp_ % pass_samples_));
}

BatchView BatchPlan::operator[](std::uint64_t batch) const {
    const std::uint64_t batches_of_pass = bands_ * rounds_of(pass_samples_);
    const std::uint64_t begin = batch / batches_of_pass * pass_samples_;
    const std::uint64_t end = std::min<std::uint64_t>(spp_, begin + pass_samples_);
    const std::uint64_t rounds = rounds_of(end - begin);  // the last pass may have fewer
    const std::uint64_t in_pass = batch % batches_of_pass;
    const auto first_pixel = static_cast<std::uint32_t>(in_pass / rounds * at_once_);
    const auto first_sample = static_cast<std::uint32_t>(begin + in_pass % rounds * samples_);
    return {first_pixel, std::min(at_once_, pixels_ - first_pixel), first_sample,
            std::min(samples_, static_cast<std::uint32_t>(end) - first_sample)};
}

}  // namespace scotty::reference
