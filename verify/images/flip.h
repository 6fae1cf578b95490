/// LDR-FLIP: how different two images look, flipped back and forth.
#pragma once

#include <cstdint>
#include <vector>

#include "verify/images/measured_image.h"

namespace scotty::verify {

/// Pixels per degree of sight: 0.7 m from a monitor of 0.7 m and 3840 pixels, the paper's default.
inline constexpr double kFlipPixelsPerDegree = 3840.0 * 3.14159265358979323846 / 180.0;

/// One value in [0, 1] per pixel, after Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and
/// Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020. Linear radiance is
/// first clamped to [0, 1], as an sRGB screen would. Both have one size and finite values.
std::vector<double> flip_map(const MeasuredImage& image, const MeasuredImage& golden);

}  // namespace scotty::verify
