/// A pixel's mean over its samples and the variance of that mean, sample by sample.
///
/// Exact operations in sample order: the same bits however the samples come in batches.
#pragma once

#include <cstdint>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"

namespace scotty::reference {

/// Between batches the sum of the samples and of their squared deviations from the mean (Welford
/// 1962); finish() makes the mean of it, and the variance of the mean.
struct PixelSums {
    Vec3 image{0.0f, 0.0f, 0.0f};
    Vec3 variance{0.0f, 0.0f, 0.0f};
};

/// `before`: samples that are in the sums already.
SCOTTY_HD void add_sample(PixelSums& sums, std::uint32_t before, const Vec3& radiance) {
    if (before > 0) {
        const auto n = static_cast<float>(before);
        const Vec3 deviation = radiance - sums.image / n;
        sums.variance += deviation * deviation * (n / (n + 1.0f));
    }
    sums.image += radiance;
}

/// Of all `samples`; the variance of one sample is not known, and 0.
SCOTTY_HD void finish(PixelSums& sums, std::uint32_t samples) {
    const auto n = static_cast<float>(samples);
    sums.image /= n;
    sums.variance =
        samples > 1 ? sums.variance * (1.0f / (n * (n - 1.0f))) : Vec3(0.0f, 0.0f, 0.0f);
}

}  // namespace scotty::reference
