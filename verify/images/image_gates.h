/// The statistical verdict on an image: can it be the same picture as its golden image, apart from
/// noise?
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "verify/images/measured_image.h"

namespace scotty::verify {

/// In the order in which they are asked; a failure of layout or finite ends the rest.
enum class Gate {
    layout,  ///< same width and height, variances where they are needed
    finite,  ///< no NaN, no infinity, no negative radiance
    global,  ///< mean of the whole image: sees a bias of a percent
    tile,    ///< 8x8 tiles by Welch's test: sees a region
    pixel,   ///< single pixels: sees dots; for light-tailed scenes only
    equal,   ///< in place of the last three where no noise is known: equal, or within a tolerance
};
std::string_view name(Gate gate);

/// Settings of the three statistical gates; verify/images/image_noise.h says how they measure.
struct GateSettings {
    /// Probability that an image without a fault fails any gate at all, for one image. It is
    /// divided among gates and, after Sidak, among tiles, pixels and channels.
    double false_alarm = 1e-4;
    /// The pixel gate assumes that the mean of a pixel's samples is nearly normal, which fails with
    /// caustics.
    bool light_tailed = true;
};

struct GateResult {
    Gate gate = Gate::layout;
    bool ran = true;  ///< false: the gate does not apply; `text` says why
    bool passed = true;
    double statistic = 0.0;  ///< largest |z| or |t| found
    double p_value = 1.0;    ///< its two-sided probability, before correction
    double threshold = 0.0;  ///< p_value below which the gate fails
    /// The region that the statistic belongs to, in pixels.
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
    std::uint32_t channel = 0;
    std::string text;    ///< one sentence, with the place and both values
    std::string waiver;  ///< what lets the failure pass for a while (verify/golden/waivers.h)

    bool failed() const { return ran && !passed && waiver.empty(); }
};

/// The share of each of `images` images, for a run to have `run` altogether (Sidak).
double false_alarm_per_image(double run, std::uint64_t images);

/// Shown beside a verdict, never judged by; NaN if an image is not finite or layouts differ.
struct ImageMetrics {
    double flip = 0.0;      ///< mean of the LDR-FLIP map, 0 to 1 (Andersson et al. 2020)
    double rel_mse = 0.0;   ///< mean of (a - b)^2 / (b^2 + 0.01)
    double psnr = 0.0;      ///< in dB, of the sRGB-encoded images; infinity where they are equal
    double max_ulps = 0.0;  ///< the largest distance in float32 units in the last place
};

struct WorstPixel {
    std::uint32_t x = 0, y = 0;
    double z = 0.0;  ///< largest over channels; 0 if variances are not known
    double ulps = 0.0;
    Color image{}, golden{};
};

struct ImageVerdict {
    std::vector<GateResult> gates;
    ImageMetrics metrics;
    std::vector<WorstPixel> worst;  ///< worst first, at most 10
    /// Empty, or why the images differ and noise cannot be told from a fault.
    std::string not_judged;
    bool passed() const;                      ///< every gate that ran passed or is waived
    const GateResult* first_failure() const;  ///< null if there is none
};

/// Judges by noise, which both images have to know. It never throws for a bad image: the layout or
/// the finite gate finds that.
ImageVerdict judge_image(const MeasuredImage& image, const MeasuredImage& golden,
                         const GateSettings& settings);

/// Judges by a stated tolerance: layout, finite, and `equal`. A tolerance of 0 asks for the same
/// bits; otherwise values may differ by that share of the larger value, or of the golden image's
/// mean if that is more.
ImageVerdict judge_by_tolerance(const MeasuredImage& image, const MeasuredImage& golden,
                                double tolerance);

/// Judges without noise and tolerance: layout, finite, and whether the bits are equal. If they are
/// not, the verdict is `not_judged`: `why`.
ImageVerdict judge_bits(const MeasuredImage& image, const MeasuredImage& golden,
                        const std::string& why);

}  // namespace scotty::verify
