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
    /// The estimated variance of `mean` (of the mean of all samples, not of one sample), per
    /// channel; empty if it is not known.
    std::vector<Color> variance;
    std::uint64_t samples = 0;  ///< independent samples in every pixel; 0: not known
    /// Above one if a "sample" is itself the mean of several paths, as when the variance comes from
    /// renders with other seeds. A pixel has samples * paths_per_sample paths.
    std::uint64_t paths_per_sample = 1;
};

}  // namespace scotty::verify
