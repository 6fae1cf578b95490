/// Small images for the tests of what reads, writes and judges them.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "tests/temporary_folder.h"
#include "verify/images/image_read.h"
#include "verify/images/measured_image.h"

namespace scotty::verify::test {

using tests::slurp;
using tests::spill;
using tests::TemporaryFolder;

/// Whether two files hold the same picture with the same noise, wherever it comes from.
inline bool same_picture(const std::string& a, const std::string& b) {
    const MeasuredImage one = read_image(a).image;
    const MeasuredImage other = read_image(b).image;
    return !one.mean.empty() && one.mean == other.mean && one.variance == other.variance &&
           one.samples == other.samples;
}

/// A smooth picture without noise, of no symmetry; values are floats.
inline MeasuredImage smooth_image(std::uint32_t width, std::uint32_t height) {
    MeasuredImage image{width, height, {}, {}, 0, 1};
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const double u = (x + 0.5) / width;
            const double v = (y + 0.5) / height;
            const double grey = 0.3 + 0.5 * u + 0.2 * v * v + 0.1 * std::sin(9.0 * u * v);
            image.mean.push_back({static_cast<float>(grey),
                                  static_cast<float>(0.6 * grey + 0.1 * v),
                                  static_cast<float>(0.4 * grey + 0.2 * (1.0 - u))});
        }
    }
    return image;
}

}  // namespace scotty::verify::test
