#include "verify/render/progressive.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <vector>

#include "emulation/host/pipeline.h"
#include "reference/base/assert.h"
#include "reference/numerics/pixel_sums.h"

namespace scotty::verify {

namespace buffers = reference::buffers;
namespace {

using reference::Image;
using reference::PipelineParameters;
using reference::StageKind;
using reference::StageView;
using reference::Vec3;

/// Thrown through the pipeline that is to stop.
struct Stopped {};

/// The emulator's filter, whoever rendered: filters are the same bits everywhere.
Image filtered(const PipelineInput& input, const Image& image) {
    StageView stage;
    stage.kind = StageKind::filter;
    stage.name = to_string(stage.kind);
    stage.inputs = {reference::buffer_view(buffers::image, std::span<const Vec3>(image.pixels))};
    const auto outputs =
        emulation::Pipeline(input.scene, input.bvh, input.parameters).run_stage(stage);
    SCOTTY_ASSERT(outputs.size(), ==, 1u);
    const auto* pixels = reinterpret_cast<const Vec3*>(outputs[0].bytes.data());
    return {image.width, image.height, {pixels, pixels + image.pixels.size()}};
}

/// Keeps the sums of the last complete pass, which reconstruct_image shows batch by batch.
class Passes : public reference::StageObserver {
 public:
    Passes(const PipelineInput& input, const ProgressiveListener& listener)
        : input_(input), parameters_(input.parameters), listener_(listener) {}

    bool wants(StageKind kind) const override { return kind == StageKind::reconstruct_image; }
    bool follows_launches() const override { return false; }
    void on_stage(const StageView& stage) override { follow(stage); }
    void on_batch(std::uint64_t done, std::uint64_t count) override {
        if (done < count && listener_.stops(batch_text(done, count))) throw Stopped{};
    }

    std::uint32_t samples() const { return samples_; }

    /// As reconstruct_image and the filter make it.
    Image picture() const {
        Image image{parameters_.image_width, parameters_.image_height, sums_, deviations_};
        for (std::size_t p = 0; p < image.pixels.size(); ++p) {
            reference::PixelSums sums{image.pixels[p], image.variance[p]};
            finish(sums, samples_);
            image.pixels[p] = sums.image;
            image.variance[p] = sums.variance;
        }
        if (samples_ == 1) image.variance.clear();
        const bool smooth = parameters_.filter != reference::Filter::none &&
                            samples_ < parameters_.filter_threshold;
        return smooth ? filtered(input_, image) : image;
    }

 private:
    void follow(const StageView& stage) {
        const auto pixel = stage.get(buffers::pixel);
        const auto image = stage.get(buffers::image);
        const auto deviations = stage.get(buffers::variance);
        const std::uint32_t last = parameters_.image_width * parameters_.image_height - 1;
        SCOTTY_ASSERT(image.size(), ==, std::size_t{last} + 1);
        // A render that ran out of memory begins again, with smaller batches.
        if (stage.batch == 0) of_last_pixel_ = 0;
        of_last_pixel_ += static_cast<std::uint32_t>(std::count(pixel.begin(), pixel.end(), last));
        // With the last sample the sums have become means, and the pipeline's own image is next.
        const bool pass_is_complete = of_last_pixel_ > samples_ &&
                                      of_last_pixel_ % samples_of_pass(parameters_) == 0 &&
                                      of_last_pixel_ < parameters_.spp;
        if (!pass_is_complete) return;
        sums_.assign(image.begin(), image.end());
        deviations_.assign(deviations.begin(), deviations.end());
        samples_ = of_last_pixel_;
        listener_.on_pass(samples_, [this] { return picture(); });
    }

    const PipelineInput& input_;
    const PipelineParameters& parameters_;
    const ProgressiveListener& listener_;
    std::uint32_t of_last_pixel_ = 0;  ///< samples added to the image's last pixel
    std::uint32_t samples_ = 0;        ///< of each pixel of sums_
    std::vector<Vec3> sums_, deviations_;
};

}  // namespace

std::string batch_text(std::uint64_t done, std::uint64_t count) {
    return fmt::format("batch {} of {}", std::min(done + 1, count), count);
}

ProgressiveImage render_progressively(const Backend& backend, const PipelineInput& input,
                                      const ProgressiveListener& listener) {
    Passes passes(input, listener);
    try {
        return {backend.render(input, &passes), input.parameters.spp};
    } catch (const Stopped&) {
        if (passes.samples() == 0) return {};
        return {passes.picture(), passes.samples()};
    }
}

}  // namespace scotty::verify
