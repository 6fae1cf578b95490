#include "verify/images/image_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "verify/images/image_metrics.h"
#include "verify/images/image_noise.h"

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

/// Replaces the image by the mean of all renders; each counts as one sample of its paths.
void merge_renders(ImageDiff& diff) {
    const std::vector<std::string>& also = diff.settings.also;
    if (also.empty()) return;
    MeasuredImage& image = diff.image.image;
    if (image.samples == 0) {
        throw Error::bad_input(diff.image_path,
                               "does not say its samples a pixel: state them with --samples");
    }
    const double count = 1.0 + static_cast<double>(also.size());
    std::vector<Color> squares(image.mean.size());
    const auto add = [&](std::size_t pixel, const Color& color) {
        for (std::size_t c = 0; c < 3; ++c) squares[pixel][c] += color[c] * color[c];
    };
    for (std::size_t i = 0; i < image.mean.size(); ++i) add(i, image.mean[i]);
    for (const std::string& path : also) {
        const MeasuredImage other = read_image(path, diff.settings.choice).image;
        const bool alike = other.width == image.width && other.height == image.height &&
                           (other.samples == 0 || other.samples == image.samples);
        if (!alike) {
            throw Error::bad_input(path,
                                   "has another size or number of samples than " + diff.image_path);
        }
        for (std::size_t i = 0; i < image.mean.size(); ++i) {
            add(i, other.mean[i]);
            for (std::size_t c = 0; c < 3; ++c) image.mean[i][c] += other.mean[i][c];
        }
    }
    image.variance.assign(image.mean.size(), Color{});
    for (std::size_t i = 0; i < image.mean.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            image.mean[i][c] /= count;
            const double spread = squares[i][c] - count * image.mean[i][c] * image.mean[i][c];
            image.variance[i][c] = std::max(0.0, spread) / (count * (count - 1.0));
        }
    }
    image.paths_per_sample *= image.samples;
    image.samples = 1 + also.size();
}

std::string way_out(const MeasuredImage& image, const MeasuredImage& golden) {
    if (!golden.variance.empty() && image.variance.empty()) {
        return "render it again with more than one sample a pixel to an .exr, which then says its "
               "noise; give renders with other seeds by --also; or state a --tolerance";
    }
    return "write channels variance.R, variance.G, variance.B, or state a --tolerance";
}

void judge(ImageDiff& diff) {
    const MeasuredImage& image = diff.image.image;
    const MeasuredImage& golden = diff.golden.image;
    const std::string unknown = NoisyPair::why_not(image, golden);
    if (diff.settings.tolerance) {
        diff.basis = ImageDiff::Basis::tolerance;
        diff.notes.push_back(
            fmt::format("judged by --tolerance {:g}, not by noise", *diff.settings.tolerance));
        diff.verdict = judge_by_tolerance(image, golden, *diff.settings.tolerance);
    } else if (!unknown.empty() && NoisyPair::other_layout(image, golden).empty()) {
        diff.basis = ImageDiff::Basis::bits;
        diff.verdict =
            judge_bits(image, golden, fmt::format("{}: {}", unknown, way_out(image, golden)));
    } else {
        diff.verdict = judge_image(image, golden, diff.settings.gates);
    }
}

void note_what_was_not_read(ImageDiff& diff) {
    for (const auto& [path, read] :
         {std::pair(&diff.golden_path, &diff.golden), std::pair(&diff.image_path, &diff.image)}) {
        if (read->not_read.empty()) continue;
        diff.notes.push_back(fmt::format("{}: not judged: {} (--part and --layer choose another)",
                                         *path, fmt::join(read->not_read, ", ")));
    }
}

}  // namespace

ImageDiff diff_images(const std::string& golden, const std::string& image,
                      const ImageDiffSettings& settings) {
    ImageDiff diff;
    diff.golden_path = golden;
    diff.image_path = image;
    diff.settings = settings;
    diff.golden = read_image(golden, settings.choice);
    diff.image = read_image(image, settings.choice);
    note_what_was_not_read(diff);
    state_samples(diff);
    merge_renders(diff);
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
