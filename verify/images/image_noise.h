/// Two images in a region: do their means differ by more than noise and rounding explain?
///
/// Two rules keep the answer sound where a plain Welch test is not:
/// - A pixel that by chance saw no rare bright path has a small mean and, worse, next to no
///   estimated variance. Where both images say how many paths they are made of, the larger of the
///   two estimates of one path's variance therefore holds for both, with the fewer degrees of
///   freedom.
/// - Rounding of float sums is no noise. A difference counts only beyond the error bound of adding
/// that many floats one by one, so a constant pixel (background, emitter) may differ by that only:
/// beyond it, with no variance at all, the statistic is infinite.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "verify/images/measured_image.h"

namespace scotty::verify {

struct Region {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
};

struct RegionTest {
    double image = 0.0, golden = 0.0;  ///< means of the region
    double statistic = 0.0;            ///< signed: positive where the image is brighter
    double degrees_of_freedom = 0.0;   ///< Welch-Satterthwaite; infinite where samples are unknown
};

/// A pair of images of one layout, with what is known of their noise.
class NoisyPair {
 public:
    /// Borrows both. Call why_not() first.
    NoisyPair(const MeasuredImage& image, const MeasuredImage& golden);

    /// Why these images cannot be compared by noise (sizes, variances); empty if they can.
    static std::string why_not(const MeasuredImage& image, const MeasuredImage& golden);
    /// Why their pixels cannot be compared at all; empty if they can.
    static std::string other_layout(const MeasuredImage& image, const MeasuredImage& golden);

    RegionTest test(const Region& region, std::size_t channel) const;

 private:
    struct Side {
        const MeasuredImage* image;
        double degrees_of_freedom;  ///< of each pixel's variance
        double paths;               ///< 0: not known
    };
    /// Sums over the region, not means.
    struct Sums {
        double value = 0.0, variance = 0.0, squared_variance = 0.0;
        double pixels = 0.0;
        double degrees_of_freedom(const Side& side) const;
    };
    static Side side_of(const MeasuredImage& image);
    static Sums sums(const Side& side, const Region& region, std::size_t channel);
    struct Noise {
        double variance, degrees_of_freedom;
    };
    Noise noise_of_difference(const Sums& image, const Sums& golden) const;

    Side image_, golden_;
    double rounding_;  ///< share of a sum by which float arithmetic may be off
};

/// The signed statistic of each pixel and channel; empty where noise is not known.
std::vector<Color> pixel_statistics(const MeasuredImage& image, const MeasuredImage& golden);

/// Largest |z| of the channels for each pixel; infinite where a constant pixel differs.
std::vector<double> z_map(const NoisyPair& pair, std::uint32_t width, std::uint32_t height);

}  // namespace scotty::verify
