/// Distances between images, shown beside a verdict and never judged by.
#pragma once

#include <vector>

#include "reference/contract/image.h"
#include "verify/images/image_gates.h"

namespace scotty::verify {

/// Both have one layout. NaN if a value is not finite, except for max_ulps.
ImageMetrics image_metrics(const MeasuredImage& image, const MeasuredImage& golden);

/// The number of float32 steps from one value to the other, both rounded to float32; the two zeros
/// are one. Infinite if just one of them is NaN, 0 if both are.
double ulps_between(double a, double b);

/// The largest of the channels for each pixel.
std::vector<double> ulps_map(const MeasuredImage& image, const MeasuredImage& golden);

/// Black at 0 over blue, red and yellow to white at `most`; magenta where a value is NaN.
reference::Image heat_map(const std::vector<double>& values, std::uint32_t width,
                          std::uint32_t height, double most);

}  // namespace scotty::verify
