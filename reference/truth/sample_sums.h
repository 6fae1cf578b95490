/// Samples of every pixel, added up: the mean and the noise of the mean follow from them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scotty::reference {

/// Row-major from the top left, red, green and blue of linear radiance.
struct SampleSums {
    using Color = std::array<double, 3>;

    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint64_t samples = 0;  ///< the same number in every pixel
    std::vector<Color> sum, sum_of_squares;

    SampleSums() = default;
    SampleSums(std::uint32_t w, std::uint32_t h)
        : width(w),
          height(h),
          sum(std::size_t{w} * h, Color{}),
          sum_of_squares(std::size_t{w} * h, Color{}) {}

    /// `samples` is the caller's to raise, once every pixel has had its sample.
    void add(std::size_t pixel, const Color& radiance) {
        for (std::size_t c = 0; c < 3; ++c) {
            sum[pixel][c] += radiance[c];
            sum_of_squares[pixel][c] += radiance[c] * radiance[c];
        }
    }
    /// Requires a sample.
    Color mean(std::size_t pixel) const {
        Color out{};
        for (std::size_t c = 0; c < 3; ++c) out[c] = sum[pixel][c] / static_cast<double>(samples);
        return out;
    }
    /// Estimated variance of mean(), not of one sample. Requires two samples.
    Color variance_of_mean(std::size_t pixel) const {
        const auto n = static_cast<double>(samples);
        Color out{};
        for (std::size_t c = 0; c < 3; ++c) {
            const double spread = sum_of_squares[pixel][c] - sum[pixel][c] * (sum[pixel][c] / n);
            out[c] = std::max(0.0, spread) / (n * (n - 1.0));
        }
        return out;
    }
};

}  // namespace scotty::reference
