/// Carries the analyses out, on any back end.
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
    std::vector<std::string> names;  ///< which; empty: all, in the catalog's order
    bool quick = false;              ///< a few small renders, which only shows that it works
    bool keep_size = false;          ///< the picture's size and samples are the caller's wish
    std::function<bool()> stop;      ///< asked between renders; may be empty
    /// Hears after each analysis, so that a run that ends early has lost nothing; may be empty.
    std::function<void(const AnalysisRun&)> finished;
};

/// Throws bad_input for a name that is no analysis, and as measure_renders(). All rays of a render
/// are in one traversal, whatever parameters.batch_rays says. Stopped, it has what was finished.
AnalysisRun analyze(const reference::Scene& scene, const AnalysisSettings& settings);

}  // namespace scotty::verify
