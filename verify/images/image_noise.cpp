#include "verify/images/image_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scotty::verify {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

double paths_of(const MeasuredImage& image) {
    return static_cast<double>(image.samples) * static_cast<double>(image.paths_per_sample);
}

/// The error bound of n floats added one by one: n * 2^-24 (Higham 2002, section 4.2), and a few
/// roundings more for the summands. It is capped, so that a million samples cannot hide a percent.
double rounding_share(double paths) {
    if (paths == 0.0) paths = 1024.0;
    return std::min((paths + 64.0) * std::ldexp(1.0, -24), std::ldexp(1.0, -12));
}

bool is_whole(const MeasuredImage& image) {
    const std::size_t pixels = std::size_t{image.width} * image.height;
    return pixels != 0 && image.mean.size() == pixels &&
           (image.variance.empty() || image.variance.size() == pixels);
}

}  // namespace

std::string NoisyPair::other_layout(const MeasuredImage& image, const MeasuredImage& golden) {
    if (image.width != golden.width || image.height != golden.height) {
        return fmt::format("the image has {}x{} pixels, the golden image {}x{}", image.width,
                           image.height, golden.width, golden.height);
    }
    if (!is_whole(image)) return "the image's values are not as many as its pixels";
    if (!is_whole(golden)) return "the golden image's values are not as many as its pixels";
    return {};
}

std::string NoisyPair::why_not(const MeasuredImage& image, const MeasuredImage& golden) {
    std::string layout = other_layout(image, golden);
    if (!layout.empty()) return layout;
    for (const bool ours : {true, false}) {
        const MeasuredImage& one = ours ? image : golden;
        const char* who = ours ? "the image" : "the golden image";
        if (one.variance.empty()) {
            return one.samples == 1
                       ? fmt::format("{} has one sample a pixel, which tells nothing of its noise",
                                     who)
                       : fmt::format("{} does not say how noisy it is: no variances", who);
        }
        if (one.samples == 1) {
            return fmt::format("{} claims to know a variance from a single sample", who);
        }
    }
    return {};
}

NoisyPair::Side NoisyPair::side_of(const MeasuredImage& image) {
    const double degrees_of_freedom =
        image.samples == 0 ? kUnbounded : static_cast<double>(image.samples) - 1.0;
    return {&image, degrees_of_freedom, paths_of(image)};
}

NoisyPair::NoisyPair(const MeasuredImage& image, const MeasuredImage& golden)
    : image_(side_of(image)),
      golden_(side_of(golden)),
      rounding_(rounding_share(paths_of(image))) {}

/// Satterthwaite's degrees of freedom of a sum of independent estimates that have the same each.
/// Estimates of zero are equal ones: that a few samples are alike says little of a pixel's noise.
double NoisyPair::Sums::degrees_of_freedom(const Side& side) const {
    if (!(squared_variance > 0.0)) return side.degrees_of_freedom * pixels;
    return side.degrees_of_freedom * variance * variance / squared_variance;
}

NoisyPair::Sums NoisyPair::sums(const Side& side, const Region& region, std::size_t channel) {
    Sums sums;
    sums.pixels = static_cast<double>(region.width) * region.height;
    for (std::uint32_t y = region.y; y < region.y + region.height; ++y) {
        for (std::uint32_t x = region.x; x < region.x + region.width; ++x) {
            const std::size_t pixel = std::size_t{y} * side.image->width + x;
            sums.value += side.image->mean[pixel][channel];
            const double variance = side.image->variance[pixel][channel];
            sums.variance += variance;
            sums.squared_variance += variance * variance;
        }
    }
    return sums;
}

NoisyPair::Noise NoisyPair::noise_of_difference(const Sums& image, const Sums& golden) const {
    const double df_image = image.degrees_of_freedom(image_);
    const double df_golden = golden.degrees_of_freedom(golden_);
    if (image_.paths != 0.0 && golden_.paths != 0.0) {
        // The fewer degrees of freedom hold too: an estimate from few samples can be the smaller
        // one by chance, and the other image's certainty says nothing about this one's noise.
        const double path =
            std::max(image.variance * image_.paths, golden.variance * golden_.paths);
        return {path * (1.0 / image_.paths + 1.0 / golden_.paths), std::min(df_image, df_golden)};
    }
    const double variance = image.variance + golden.variance;
    const double spread =
        image.variance * image.variance / df_image + golden.variance * golden.variance / df_golden;
    return {variance, spread > 0.0 ? variance * variance / spread : kUnbounded};
}

RegionTest NoisyPair::test(const Region& region, std::size_t channel) const {
    const Sums image = sums(image_, region, channel);
    const Sums golden = sums(golden_, region, channel);
    RegionTest test;
    test.image = image.value / image.pixels;
    test.golden = golden.value / golden.pixels;
    const Noise noise = noise_of_difference(image, golden);
    test.degrees_of_freedom = noise.degrees_of_freedom;
    const double difference = image.value - golden.value;
    const double slack = rounding_ * std::max(std::abs(image.value), std::abs(golden.value));
    const double excess = std::abs(difference) - slack;
    if (!(excess > 0.0)) return test;
    const double size = noise.variance > 0.0 ? excess / std::sqrt(noise.variance) : kUnbounded;
    test.statistic = std::copysign(size, difference);
    return test;
}

std::vector<Color> pixel_statistics(const MeasuredImage& image, const MeasuredImage& golden) {
    if (!NoisyPair::why_not(image, golden).empty()) return {};
    const NoisyPair pair(image, golden);
    std::vector<Color> z(image.mean.size());
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            for (std::size_t channel = 0; channel < 3; ++channel) {
                z[std::size_t{y} * image.width + x][channel] =
                    pair.test({x, y, 1, 1}, channel).statistic;
            }
        }
    }
    return z;
}

std::vector<double> z_map(const NoisyPair& pair, std::uint32_t width, std::uint32_t height) {
    std::vector<double> map;
    map.reserve(std::size_t{width} * height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            double worst = 0.0;
            for (std::size_t c = 0; c < 3; ++c) {
                worst = std::max(worst, std::abs(pair.test({x, y, 1, 1}, c).statistic));
            }
            map.push_back(worst);
        }
    }
    return map;
}

}  // namespace scotty::verify
