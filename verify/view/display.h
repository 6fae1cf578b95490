/// From radiance, or what a stage gave, to 8-bit colours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/image.h"
#include "verify/view/messages.h"

namespace scotty::verify {

/// 8-bit RGB, row-major.
struct ColorImage {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

/// sRGB of tone(radiance * 2^exposure). `exact` is what `scotty render -o X.png` writes (with
/// ToneMap::clamp); otherwise a table of 65,536 radiances answers, which is at most one step off.
ColorImage to_srgb(const reference::Image& image, float exposure, ToneMap tone, bool exact);

/// A number for each pixel, NaN where there is none.
struct FeatureImage {
    std::uint32_t width = 0, height = 0;
    std::vector<float> values;
    ViewSubject subject = ViewSubject::distance;
    std::vector<reference::Vec3> normals;  ///< of ViewSubject::normal instead
};
/// What the colours stand for: the numbers of the first and the last of a scale.
struct ColorLegend {
    double low = 0.0, high = 0.0;
    bool logarithmic = false;
    std::string unit;  ///< empty: there is no scale
};
/// Distances and variances by a scale from dark to light, counts by the same in whole steps,
/// primitives by a colour of their own, normals as (n + 1) / 2; black where there is nothing.
ColorImage false_colors(const FeatureImage& feature, ColorLegend& legend);

}  // namespace scotty::verify
