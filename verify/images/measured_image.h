/// An image that knows its own noise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace scotty::verify {

/// Red, green and blue of linear radiance, summed in double precision.
using Color = std::array<double, 3>;

/// Row-major from the top left; pixel (x, y) is mean[y * width + x].
struct MeasuredImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<Color> mean;
    /// Estimated variance of `mean` (of the mean of all samples, not of one sample), per channel;
    /// empty where it is not known.
    std::vector<Color> variance;
    std::uint64_t samples = 0;  ///< independent samples in every pixel; 0: not known
    /// More than one where a "sample" is itself the mean of so many paths, as when the variance
    /// comes from renders with other seeds. Paths in a pixel: samples * paths_per_sample.
    std::uint64_t paths_per_sample = 1;
};

}  // namespace scotty::verify
