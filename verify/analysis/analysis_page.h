/// Shows analyses to people: one page with everything, and text for the terminal.
#pragma once

#include <string>
#include <vector>

#include "verify/analysis/analysis.h"

namespace scotty::verify {

/// One HTML file that fetches nothing: for each analysis of any run, the figure, the finding, what
/// the 2018 paper says, and the numbers.
std::string analysis_page(const std::vector<AnalysisRun>& runs);

/// The same without figures.
std::string analysis_text(const std::vector<AnalysisRun>& runs);

}  // namespace scotty::verify
