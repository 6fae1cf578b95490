/// The 2018 paper's analyses as data: what is drawn over what, and what the paper says about it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verify/analysis/analysis.h"
#include "verify/pages/chart.h"

namespace scotty::verify {

/// How a panel scales values before it draws them, so that machines a hundred times apart, and the
/// 2018 paper's, can be compared. The tables keep the values.
enum class Relative {
    none,
    to_least,  ///< over the least value of the series: 1 is the fastest
    to_first,  ///< over the value of the first point
    share      ///< percent of the sum of the series
};

struct PanelDefinition {
    bool bars = false;
    ChartAxis x, y;
    Relative relative = Relative::none;
    std::string column;  ///< the name of y in the table: "ms a render"
};

/// Values that others have found.
struct GivenSeries {
    std::size_t panel = 0;
    std::string name;    ///< "paper, GTX 1080 Ti"
    std::string source;  ///< where they are published, and how they were measured
    std::vector<AnalysisPoint> points;
    std::string column{};  ///< in the table; empty: the panel's
};

/// A thin straight line: a level, or a slope in a log-log panel.
struct GuideDefinition {
    std::size_t panel = 0;
    std::string name;
    std::optional<double> level;  ///< y everywhere
    std::optional<double> slope;  ///< through the first point of the first series
};

struct AnalysisDefinition {
    std::string name;    ///< on the command line
    std::string title;   ///< of the figure
    std::string report;  ///< what the 2018 paper says, in a sentence or two
    std::string how;     ///< what is measured here, and what is not
    std::vector<PanelDefinition> panels;
    std::vector<GivenSeries> given;
    std::vector<GuideDefinition> guides;
};

/// In the 2018 paper's order.
const std::vector<AnalysisDefinition>& analysis_catalog();

/// Throws bad_input naming `where` and the known names.
const AnalysisDefinition& analysis_named(const std::string& where, const std::string& name);

}  // namespace scotty::verify
