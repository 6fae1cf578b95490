#include "verify/render/progressive.h"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "emulation/kernels/filter_image.h"
#include "reference/base/assert.h"
#include "reference/contract/batch_plan.h"
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

/// The plan of a render that announces so many batches: one that ran out of memory begins again
/// with batches of half as many rays.
reference::BatchPlan plan_of(PipelineParameters parameters, std::uint64_t count) {
    while (reference::BatchPlan(parameters).size() < count && parameters.batch_rays > 1) {
        parameters.batch_rays /= 2;
    }
    return reference::BatchPlan(parameters);
}

/// Calls f(first, end) for parts of a picture's pixels, in parallel.
template <class F>
void for_pixel_ranges(std::size_t pixels, const F& f) {
    constexpr std::size_t kGrain = 1u << 14;
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, pixels, kGrain),
                              [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                                  f(range.begin(), range.end());
                              });
}

void copy_pixels(std::span<const Vec3> from, std::vector<Vec3>& to) {
    to.resize(from.size());
    for_pixel_ranges(from.size(), [&](std::size_t first, std::size_t end) {
        std::copy(&from[first], &from[first] + (end - first), &to[first]);
    });
}

/// Keeps the sums of the last complete pass, which reconstruct_image shows.
class Passes : public reference::StageObserver {
 public:
    Passes(const PipelineInput& input, const ProgressiveListener& listener)
        : input_(input), parameters_(input.parameters), listener_(listener) {}

    bool wants(StageKind kind) const override {
        return kind == StageKind::reconstruct_image && samples_next_ != 0;
    }
    bool follows_launches() const override { return false; }
    void on_stage(const StageView& stage) override {
        if (samples_next_ == 0) return;
        const auto image = stage.get(buffers::image);
        const auto deviations = stage.get(buffers::variance);
        SCOTTY_ASSERT(image.size(), ==,
                      std::size_t{parameters_.image_width} * parameters_.image_height);
        copy_pixels(image, sums_);
        copy_pixels(deviations, deviations_);
        samples_ = samples_next_;
        listener_.on_pass(samples_, [this] { return picture(); });
    }
    void on_batch(std::uint64_t done, std::uint64_t count) override {
        if (done == count) return;
        if (done == 0) plan_.emplace(plan_of(parameters_, count));
        samples_next_ = samples_of_pass_that_ends((*plan_)[done]);
        const bool is_new = samples_next_ > samples_;
        if (!is_new || !wants_pass(samples_next_)) samples_next_ = 0;
        if (listener_.stops(batch_text(done, count))) throw Stopped{};
    }

    std::uint32_t samples() const { return samples_; }

    /// As reconstruct_image and the filter make it.
    Image picture() const {
        Image image{parameters_.image_width, parameters_.image_height, {}, {}};
        oneapi::tbb::parallel_invoke([&] { image.pixels = sums_; },
                                     [&] { image.variance = deviations_; });
        for_pixel_ranges(image.pixels.size(), [&](std::size_t first, std::size_t end) {
            for (std::size_t p = first; p < end; ++p) {
                reference::PixelSums sums{image.pixels[p], image.variance[p]};
                finish(sums, samples_);
                image.pixels[p] = sums.image;
                image.variance[p] = sums.variance;
            }
        });
        if (samples_ == 1) image.variance.clear();
        const bool smooth = parameters_.filter != reference::Filter::none &&
                            samples_ < parameters_.filter_threshold;
        return smooth ? filtered_image(image, parameters_.filter) : image;
    }

 private:
    bool wants_pass(std::uint32_t samples) const {
        return listener_.wants_pass == nullptr || listener_.wants_pass(samples);
    }
    /// Of each pixel, when this batch is done; 0 where it ends no pass, or the last: with the last
    /// sample the sums become means, and the pipeline's own image is next.
    std::uint32_t samples_of_pass_that_ends(const reference::BatchView& batch) const {
        const std::uint32_t pixels = parameters_.image_width * parameters_.image_height;
        const std::uint32_t samples = batch.first_sample + batch.samples;
        const bool ends = batch.first_pixel + batch.pixels == pixels &&
                          samples % samples_of_pass(parameters_) == 0 && samples < parameters_.spp;
        return ends ? samples : 0;
    }

    const PipelineInput& input_;
    const PipelineParameters& parameters_;
    const ProgressiveListener& listener_;
    std::optional<reference::BatchPlan> plan_;
    std::uint32_t samples_next_ = 0;  ///< that the batch in flight completes and that are shown
    std::uint32_t samples_ = 0;       ///< of each pixel of sums_
    std::vector<Vec3> sums_, deviations_;
};

}  // namespace

Image filtered_image(const Image& image, reference::Filter filter) {
    Image filtered{image.width, image.height, {}, {}};
    filtered.pixels.resize(image.pixels.size());
    const emulation::FilterView view{image.width, image.height, image.pixels.data(),
                                     filtered.pixels.data()};
    for_pixel_ranges(image.pixels.size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t p = first; p < end; ++p) {
            emulation::filter_image(static_cast<std::uint32_t>(p), filter, view);
        }
    });
    return filtered;
}

std::string batch_text(std::uint64_t done, std::uint64_t count) {
    return fmt::format("batch {} of {}", std::min(done + 1, count), count);
}

class ProgressiveRenderer::State {
 public:
    State(const Backend& backend, const PipelineInput& input, bool timed)
        : input_(input),
          pipeline_(backend.make(input.scene, input.bvh, input.parameters,
                                 {.observer = &relay_, .timed = timed})) {}

    ProgressiveImage render(const ProgressiveListener& listener) {
        Passes passes(input_, listener);
        try {
            return {render_observed(passes), input_.parameters.spp};
        } catch (const Stopped&) {
            if (passes.samples() == 0) return {};
            return {passes.picture(), passes.samples()};
        }
    }
    Image render_observed(reference::StageObserver& observer) {
        pipeline_->look(input_.scene.camera, input_.parameters);
        const Watched watched(relay_, observer);
        return pipeline_->render();
    }
    reference::PipelineInterface& pipeline() { return *pipeline_; }

 private:
    /// Hands everything on to whoever is watching at the time.
    class Relay : public reference::StageObserver {
     public:
        bool wants(StageKind kind) const override { return to != nullptr && to->wants(kind); }
        bool follows_launches() const override { return to != nullptr && to->follows_launches(); }
        void on_batch(std::uint64_t done, std::uint64_t count) override {
            if (to != nullptr) to->on_batch(done, count);
        }
        void on_stage(const StageView& stage) override { to->on_stage(stage); }
        void on_retry(std::string_view stage, std::string_view reason) override {
            if (to != nullptr) to->on_retry(stage, reason);
        }

        reference::StageObserver* to = nullptr;
    };
    struct Watched {
        Watched(Relay& through, reference::StageObserver& observer) : relay(through) {
            relay.to = &observer;
        }
        ~Watched() { relay.to = nullptr; }
        Watched(const Watched&) = delete;
        Watched& operator=(const Watched&) = delete;
        Relay& relay;
    };

    const PipelineInput& input_;
    Relay relay_;
    std::unique_ptr<reference::PipelineInterface> pipeline_;
};

ProgressiveRenderer::ProgressiveRenderer(const Backend& backend, const PipelineInput& input,
                                         bool timed)
    : state_(std::make_unique<State>(backend, input, timed)) {}
ProgressiveRenderer::~ProgressiveRenderer() = default;
ProgressiveImage ProgressiveRenderer::render(const ProgressiveListener& listener) {
    return state_->render(listener);
}
Image ProgressiveRenderer::render_observed(reference::StageObserver& observer) {
    return state_->render_observed(observer);
}
reference::PipelineInterface& ProgressiveRenderer::pipeline() { return state_->pipeline(); }

ProgressiveImage render_progressively(const Backend& backend, const PipelineInput& input,
                                      const ProgressiveListener& listener) {
    return ProgressiveRenderer(backend, input).render(listener);
}

}  // namespace scotty::verify
