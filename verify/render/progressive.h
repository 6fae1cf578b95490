/// A render whose picture can be looked at, and stopped, after every pass of samples.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "reference/contract/image.h"
#include "verify/backends/backend.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

/// Both are called by the thread that renders, between batches.
struct ProgressiveListener {
    /// Every pixel has had so many samples, more than before. picture() makes the image that a
    /// render of that many gives, bit for bit, filter included; only while the call lasts.
    std::function<void(std::uint32_t samples, const std::function<reference::Image()>& picture)>
        on_pass;
    /// What is being done, before each batch. True stops the render.
    std::function<bool(const std::string& stage)> stops;
};

/// "batch 3 of 16", where two are done.
std::string batch_text(std::uint64_t done, std::uint64_t count);

struct ProgressiveImage {
    reference::Image image;     ///< of the last pass that was completed; empty where none was
    std::uint32_t samples = 0;  ///< a pixel; parameters.spp unless the render was stopped
};

/// Renders input.parameters.spp samples in passes of input.parameters.samples_per_pass, with
/// buffers, scene and BVH staying where they are. What is rendered whole is Backend::render()'s.
ProgressiveImage render_progressively(const Backend& backend, const PipelineInput& input,
                                      const ProgressiveListener& listener);

}  // namespace scotty::verify
