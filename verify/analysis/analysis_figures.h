/// Results as figures and tables: those of several machines, and the 2018 paper's, in one.
#pragma once

#include <string>
#include <vector>

#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_catalog.h"

namespace scotty::verify {

/// One series of a panel, from any source.
struct FigureSeries {
    std::string name;
    int color = 0;
    LineStyle style = LineStyle::line;
    const std::vector<AnalysisPoint>* points = nullptr;
    std::string column;  ///< the name of y in the table
};
/// The series of all runs that have the analysis, in their order, then the given ones.
std::vector<FigureSeries> series_of(const AnalysisDefinition& definition, std::size_t panel,
                                    const std::vector<AnalysisRun>& runs);

/// `points` scaled as the panel draws them.
std::vector<ChartPoint> drawn(const std::vector<AnalysisPoint>& points, Relative relative);

/// The whole figure as an SVG file.
std::string figure(const AnalysisDefinition& definition, const std::vector<AnalysisRun>& runs);

/// A panel's numbers: a row per place, a column per series and for each of its further columns. The
/// first row is the head.
std::vector<std::vector<std::string>> numbers(const AnalysisDefinition& definition,
                                              std::size_t panel,
                                              const std::vector<AnalysisRun>& runs);

}  // namespace scotty::verify
