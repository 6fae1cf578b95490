/// Carries out the analyses on any back end.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "verify/analysis/analysis.h"
#include "verify/bench/measure.h"

namespace scotty::verify {

struct AnalysisSettings {
    /// Back end, threads, repeats, warm-ups and progress, and the parameters that are not swept.
    RenderSettings render;
    std::vector<std::string> names;  ///< the analyses to run; empty: all, in the catalog's order
    bool quick = false;              ///< a few small renders, which only show that it works
    bool keep_size = false;          ///< the caller has chosen the picture's size and samples
    std::function<bool()> stop;      ///< asked between renders; may be empty
    /// Called after each analysis, so that a run that ends early loses nothing; may be empty.
    std::function<void(const AnalysisRun&)> finished;
};

/// Throws bad_input for an unknown analysis, and as measure_renders() does. All rays of a render
/// are in one traversal, whatever parameters.batch_rays says. If stopped, it returns what is done.
AnalysisRun analyze(const reference::Scene& scene, const AnalysisSettings& settings);

}  // namespace scotty::verify
