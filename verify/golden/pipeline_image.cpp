#include "verify/golden/pipeline_image.h"

#include <fmt/format.h>

#include <cmath>

#include "reference/base/assert.h"
#include "reference/base/error.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::SampleSums;
using reference::Vec3;

MeasuredImage measured(const SampleSums& sums) {
    SCOTTY_ASSERT(sums.samples, >=, 2u);
    MeasuredImage image;
    image.width = sums.width;
    image.height = sums.height;
    image.samples = sums.samples;
    for (std::size_t pixel = 0; pixel < sums.sum.size(); ++pixel) {
        image.mean.push_back(sums.mean(pixel));
        image.variance.push_back(sums.variance_of_mean(pixel));
    }
    return image;
}

RadianceMeter::RadianceMeter(const reference::PipelineParameters& p)
    : paths_(std::uint64_t{p.image_width} * p.image_height * p.spp),
      sums_(p.image_width, p.image_height) {
    sums_.samples = p.spp;
}

bool RadianceMeter::wants(reference::StageKind kind) const {
    return kind == reference::StageKind::reconstruct_image;
}

void RadianceMeter::on_stage(const reference::StageView& stage) {
    if (!wants(stage.kind)) return;
    const auto radiance = stage.get(buffers::radiance);
    const auto pixel = stage.get(buffers::pixel);
    SCOTTY_ASSERT(radiance.size(), ==, pixel.size());
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        SCOTTY_ASSERT(pixel[i], <, sums_.sum.size());
        sums_.add(pixel[i], {radiance[i].x, radiance[i].y, radiance[i].z});
    }
    added_ += radiance.size();
}

const SampleSums& RadianceMeter::sums() const {
    SCOTTY_ASSERT(added_, ==, paths_);
    return sums_;
}

namespace {

/// Additions in float32 lose at most half a unit in the last place each, and so does the division.
std::string reconstruction_fault(const reference::Image& image, const SampleSums& sums) {
    if (image.width != sums.width || image.height != sums.height ||
        image.pixels.size() != sums.sum.size()) {
        return fmt::format("the picture is {}x{} pixels, expected {}x{}", image.width, image.height,
                           sums.width, sums.height);
    }
    const double share = static_cast<double>(sums.samples + 1) * 0x1p-24;
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
        const Color mean = sums.mean(pixel);
        for (int c = 0; c < 3; ++c) {
            const double found = image.pixels[pixel][c];
            const double expected = mean[static_cast<std::size_t>(c)];
            // Where a path's radiance is no number the picture is none either.
            if (std::isnan(found) && std::isnan(expected)) continue;
            if (found == expected || std::abs(found - expected) <= share * std::abs(expected)) {
                continue;
            }
            return fmt::format(
                "reconstruct_image: pixel ({}, {}), channel {} is {:.9g}, the mean of its paths "
                "{:.9g}",
                pixel % sums.width, pixel / sums.width, "RGB"[c], found, expected);
        }
    }
    return "";
}

}  // namespace

PipelineImage measure_pipeline(const Backend& backend, const PipelineInput& input) {
    SCOTTY_ASSERT(static_cast<int>(input.parameters.filter), ==,
                  static_cast<int>(reference::Filter::none));
    RadianceMeter meter(input.parameters);
    const reference::Image image = backend.render(input, &meter);
    return {measured(meter.sums()), reconstruction_fault(image, meter.sums())};
}

}  // namespace scotty::verify
