/// The ten analyses, each carried out by its function (analysis_catalog.h describes them).
#pragma once

#include <algorithm>
#include <string>

#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_measure.h"
#include "verify/analysis/analysis_renders.h"

namespace scotty::verify {

using Analyzer = AnalysisResult(const AnalysisSettings&, AnalysisRenders&);

// Whole renders with one parameter changed (analysis_sweeps.cpp).
Analyzer analyze_rays, analyze_width, analyze_rays_per_block, analyze_early_out, analyze_memory;
// What the launches and queues of a render show (analysis_launches.cpp).
Analyzer analyze_bounces, analyze_levels, analyze_stages, analyze_strided, analyze_limited_blocks;

/// A picture of this size, unless the caller has chosen one; with `quick` a small one.
inline reference::PipelineParameters sized(const AnalysisSettings& settings, std::uint32_t side,
                                           std::uint32_t spp) {
    reference::PipelineParameters p = settings.render.parameters;
    if (settings.keep_size) return p;
    p.image_width = p.image_height = settings.quick ? std::min(side, 64u) : side;
    p.spp = settings.quick ? std::min(spp, 2u) : spp;
    return p;
}

/// The 2018 paper's usual picture.
inline reference::PipelineParameters usual(const AnalysisSettings& settings) {
    return sized(settings, 256, 4);
}

/// A count, or a time that was taken once.
inline AnalysisPoint exactly(double x, const std::string& label, double y) {
    return {x, label, y, y, y};
}

}  // namespace scotty::verify
