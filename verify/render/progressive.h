/// A render whose picture can be looked at, and stopped, after every pass of samples.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "reference/contract/image.h"
#include "verify/backends/backend.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

/// All are called by the thread that renders, between batches.
struct ProgressiveListener {
    /// Every pixel has had so many samples, more than before. picture() makes the image that a
    /// render of that many gives, bit for bit, filter included; only while the call lasts.
    std::function<void(std::uint32_t samples, const std::function<reference::Image()>& picture)>
        on_pass;
    /// What is being done, before each batch. True stops the render.
    std::function<bool(const std::string& stage)> stops;
    /// Whether the pass that ends with so many samples is to be shown by on_pass(): a device hands
    /// out its sums only where somebody looks. Where this is missing, all are.
    std::function<bool(std::uint32_t samples)> wants_pass = {};
};

/// "batch 3 of 16", where two are done.
std::string batch_text(std::uint64_t done, std::uint64_t count);

struct ProgressiveImage {
    reference::Image image;     ///< of the last pass that was completed; empty where none was
    std::uint32_t samples = 0;  ///< a pixel; parameters.spp unless the render was stopped
};

/// One pipeline for renders that follow one another. The input is borrowed and may change between
/// renders, but for what PipelineInterface::look() wants to stay.
class ProgressiveRenderer {
 public:
    /// `timed`: launches carry their seconds, on a device too.
    ProgressiveRenderer(const Backend& backend, const PipelineInput& input, bool timed = false);
    ~ProgressiveRenderer();

    /// Renders input.parameters.spp samples from input.scene.camera, in passes of
    /// input.parameters.samples_per_pass, with buffers, scene and BVH staying where they are.
    ProgressiveImage render(const ProgressiveListener& listener);
    /// The same in one piece, with every stage shown that `observer` wants.
    reference::Image render_observed(reference::StageObserver& observer);

    /// Launches since the last clear_launches().
    reference::PipelineInterface& pipeline();

 private:
    class State;
    std::unique_ptr<State> state_;
};

/// The same for one render.
ProgressiveImage render_progressively(const Backend& backend, const PipelineInput& input,
                                      const ProgressiveListener& listener);

/// `image` as the filter, which is not none, makes it, by the emulator's kernel: in the bits of the
/// stage on every back end,
/// without a variance, since neighbours share their noise.
reference::Image filtered_image(const reference::Image& image, reference::Filter filter);

}  // namespace scotty::verify
