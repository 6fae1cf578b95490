#include "verify/image_diff.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "reference/error.h"
#include "verify/image_metrics.h"
#include "verify/image_noise.h"

namespace scotty::verify {
namespace {

using reference::Error;

void state_samples(ImageDiff& diff) {
    MeasuredImage& image = diff.image.image;
    if (diff.settings.samples == 0) return;
    if (image.samples != 0 && image.samples != diff.settings.samples) {
        throw Error::bad_input("--samples",
                               fmt::format("{} says that it has {} samples a pixel, not {}",
                                           diff.image_path, image.samples, diff.settings.samples));
    }
    image.samples = diff.settings.samples;
}

std::string way_out(const MeasuredImage& image, const MeasuredImage& golden) {
    if (golden.variance.empty()) {
        return "write channels variance.R, variance.G, variance.B, or state --tolerance";
    }
    if (image.samples == 0 && golden.samples != 0) {
        return "state the image's samples a pixel with --samples to judge it by the golden image's "
               "noise, or --tolerance";
    }
    return "state --tolerance";
}

void judge(ImageDiff& diff) {
    const MeasuredImage& image = diff.image.image;
    const MeasuredImage& golden = diff.golden.image;
    const std::string unknown = NoisyPair::why_not(image, golden);
    if (diff.settings.tolerance) {
        diff.basis = ImageDiff::Basis::tolerance;
        diff.note =
            fmt::format("judged by --tolerance {:g}, not by noise", *diff.settings.tolerance);
    } else if (!unknown.empty() && NoisyPair::other_layout(image, golden).empty()) {
        diff.basis = ImageDiff::Basis::bits;
        diff.note = fmt::format("{}; judged bit for bit ({})", unknown, way_out(image, golden));
    }
    diff.verdict = diff.basis == ImageDiff::Basis::noise
                       ? judge_image(image, golden, diff.settings.gates)
                       : judge_without_noise(image, golden, diff.settings.tolerance.value_or(0.0));
    if (diff.basis == ImageDiff::Basis::noise && unknown.empty() &&
        (image.variance.empty() || golden.variance.empty())) {
        diff.note = fmt::format("{} has no variances: taken from the other's by their samples",
                                image.variance.empty() ? "the image" : "the golden image");
    }
}

}  // namespace

ImageDiff diff_images(const std::string& image, const std::string& golden,
                      const ImageDiffSettings& settings) {
    ImageDiff diff;
    diff.image_path = image;
    diff.golden_path = golden;
    diff.settings = settings;
    diff.image = read_image(image);
    diff.golden = read_image(golden);
    state_samples(diff);
    judge(diff);
    return diff;
}

void write_heat_map(const ImageDiff& diff, const std::string& path) {
    const MeasuredImage& image = diff.image.image;
    const MeasuredImage& golden = diff.golden.image;
    if (diff.basis == ImageDiff::Basis::noise && NoisyPair::why_not(image, golden).empty()) {
        const std::vector<double> z = z_map(NoisyPair(image, golden), image.width, image.height);
        write_image(heat_map(z, image.width, image.height, 8.0), path);
        return;
    }
    std::vector<double> ulps = ulps_map(image, golden);
    for (double& value : ulps) value = std::log2(1.0 + value);
    write_image(heat_map(ulps, image.width, image.height, 24.0), path);
}

}  // namespace scotty::verify
