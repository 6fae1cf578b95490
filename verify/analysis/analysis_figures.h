/// Results as figures and tables: those of several machines, and the report's, in one.
#pragma once

#include <string>
#include <vector>

#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_catalog.h"

namespace scotty::verify {

/// One series of a panel, whoever has measured it.
struct FigureSeries {
    std::string name;
    int color = 0;
    LineStyle style = LineStyle::line;
    const std::vector<AnalysisPoint>* points = nullptr;
    std::string column;  ///< what y is, in the table
};
/// Of all runs that have the analysis, in their order, then what is given.
std::vector<FigureSeries> series_of(const AnalysisDefinition& definition, std::size_t panel,
                                    const std::vector<AnalysisRun>& runs);

/// `points` as the panel draws them.
std::vector<ChartPoint> drawn(const std::vector<AnalysisPoint>& points, Relative relative);

/// The whole figure as an SVG file.
std::string figure(const AnalysisDefinition& definition, const std::vector<AnalysisRun>& runs);

/// A panel's numbers: a row a place, a column a series and each of its further columns. The first
/// row is the head.
std::vector<std::vector<std::string>> numbers(const AnalysisDefinition& definition,
                                              std::size_t panel,
                                              const std::vector<AnalysisRun>& runs);

}  // namespace scotty::verify
