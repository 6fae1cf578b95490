/// A render that is seen while it goes on: in its file, in a viewer, on the terminal.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "verify/render/progressive.h"

namespace scotty::verify {

/// Where a picture goes.
struct RenderOutput {
    std::string file;  ///< .exr, .png or .npy
    float exposure = 0.0f;
    std::string display;  ///< HOST:PORT of a viewer; empty: none
    /// What an EXR, or the .json beside an .npy, says about where it comes from.
    std::map<std::string, std::string> provenance = {};
};

/// An EXR or .npy has the variance of each pixel, how many paths a pixel has, and
/// `output.provenance`, unless a filter mixed pixels: `scotty diff` judges it by that. Throws as
/// write_image() does.
void write_picture(const RenderOutput& output, const reference::PipelineParameters& parameters,
                   const reference::Image& image, std::uint32_t samples);

struct WatchedRender {
    ProgressiveImage picture;  ///< the file's, too, if it has samples
    int signal = 0;            ///< what stopped it; 0: it is whole
};

/// Renders pass by pass. The file is written about once a second and at the end, the display a few
/// times as often; neither takes more than about a tenth of the time. SIGINT and SIGTERM stop the
/// render (StopSignals). A display that fails is warned of and done without.
WatchedRender render_watched(const Backend& backend, const PipelineInput& input,
                             const RenderOutput& output);

}  // namespace scotty::verify
