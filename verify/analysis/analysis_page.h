/// Analyses for people: one page with everything, and text for the terminal.
#pragma once

#include <string>
#include <vector>

#include "verify/analysis/analysis.h"

namespace scotty::verify {

/// One HTML file that fetches nothing: of each analysis that any run has, the figure, what is seen,
/// what the report says, and the numbers.
std::string analysis_page(const std::vector<AnalysisRun>& runs);

/// The same without figures.
std::string analysis_text(const std::vector<AnalysisRun>& runs);

}  // namespace scotty::verify
