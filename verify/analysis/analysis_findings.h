/// The finding of an analysis: a sentence made from its numbers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verify/analysis/analysis.h"

namespace scotty::verify {

/// Least squares through the logarithms of x and y: 1 is "in proportion". Nothing for fewer than
/// two places. Throws bad_input if a value is not positive and finite.
std::optional<double> loglog_slope(const std::vector<AnalysisPoint>& points);

/// One sentence, which begins with the run's label and says where the 2018 paper's conclusion does
/// not hold. Throws internal for an analysis that is not in the catalog.
std::string finding(const AnalysisRun& run, const AnalysisResult& result);

}  // namespace scotty::verify
