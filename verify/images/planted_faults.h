/// Synthetic noisy renders, sound or with a known fault, on which the image gates are tried.
///
/// Every pixel is a small estimator of its own with the difficulties of real noise: half-shadow (a
/// light sample is seen or not), indirect light that is mostly dim and sometimes bright, a black
/// background, and on request fireflies.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "verify/images/measured_image.h"

namespace scotty::verify {

enum class ImageFault {
    none,
    brighter,              ///< radiance 1 % too high everywhere
    black_pixels,          ///< ten, scattered
    dark_tile,             ///< one 8x8 tile in full light, 5 % too dark
    not_a_number,          ///< in one pixel
    light_sample_dropped,  ///< every 16th pixel lacks one of two: half its direct light
    cosine_forgotten,      ///< in the direct light
    mirrored,              ///< left is right
    wrong_golden           ///< from another scene
};
const std::vector<ImageFault>& all_image_faults();
std::string_view name(ImageFault fault);

struct SyntheticSettings {
    std::uint32_t width = 64;
    std::uint32_t height = 64;
    std::uint32_t samples = 256;
    std::uint64_t seed = 1;
    bool fireflies = false;  ///< one path in 20000 is a thousand times as bright
};

/// A render with that fault. The same settings give the same bits on any number of threads.
MeasuredImage synthetic_render(const SyntheticSettings& settings,
                               ImageFault fault = ImageFault::none);

/// Whether the estimator has the fault; if not, plant() puts it into a finished render.
bool happens_while_rendering(ImageFault fault);
void plant(MeasuredImage& image, ImageFault fault);

/// The converged image that judges such renders, with noise of its own: `factor` times the samples,
/// another seed, and another scene for wrong_golden.
MeasuredImage synthetic_golden(SyntheticSettings settings, std::uint32_t factor = 16,
                               ImageFault fault = ImageFault::none);

}  // namespace scotty::verify
