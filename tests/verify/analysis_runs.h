/// An analysis of nothing real, with every kind of result: what figures, pages and files are tried
/// on.
#pragma once

#include <string>
#include <vector>

#include "reference/base/error.h"
#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_catalog.h"

namespace scotty::verify::test {

inline AnalysisPoint made_point(double x, double y, const std::string& label = "") {
    return {x, label, y, 0.9 * y, 1.1 * y};
}

inline std::vector<AnalysisPoint> made_points(const std::vector<double>& xs) {
    std::vector<AnalysisPoint> points;
    for (const double x : xs) points.push_back(made_point(x, 3.0 + x / 10.0));
    return points;
}

inline std::vector<AnalysisPoint> made_bars(const std::vector<std::string>& labels) {
    std::vector<AnalysisPoint> points;
    for (const std::string& label : labels) {
        points.push_back(made_point(0.0, 1.0 + static_cast<double>(points.size()), label));
        points.back().more = {{"rays", 100.0}, {"entries per ray", 5.0}};
    }
    return points;
}

/// All ten analyses; every figure is `scale` times that of another run.
inline AnalysisRun made_run(const std::string& label, double scale = 1.0) {
    const std::vector<AnalysisPoint> levels = made_points({0, 1, 2, 3, 4});
    const std::vector<AnalysisPoint> queries =
        made_bars({"primary", "direct light 1", "scene rays 1"});
    const std::vector<AnalysisPoint> policies = made_bars({"off", "level", "immediate"});
    const reference::PipelineParameters p;
    AnalysisRun run{label, "emulator", "coil", 7908, "a machine", {{"cpu", "a CPU"}}, 3, {}};
    run.results = {
        {"rays", p, {{0, "", made_points({1024, 4096, 16384})}}},
        {"width", p, {{0, "", made_points({2, 4, 8, 16})}}},
        {"rays-per-block", p, {{0, "", made_points({32, 64, 128})}}},
        {"bounces", p, {{0, "", queries}, {1, "", queries}}},
        {"levels", p, {{0, "", levels}}},
        {"stages", p, {{0, "", made_bars({"traversal", "merge", "image"})}}},
        {"early-out", p, {{0, "", policies}, {1, "", policies}}},
        {"strided", p, {{0, "linear", levels}, {0, "strided", levels}, {1, "", levels}}},
        {"limited-blocks", p, {{0, "limited", levels}, {0, "a block for every slot", levels}}},
        {"memory",
         p,
         {{0, "width 4", made_points({1024, 4096})}, {0, "width 8", made_points({1024, 4096})}}}};
    for (AnalysisResult& result : run.results) {
        for (AnalysisSeries& series : result.series) {
            for (AnalysisPoint& point : series.points) {
                point.y *= scale;
                point.low *= scale;
                point.high *= scale;
            }
        }
    }
    return run;
}

/// Of the result of that name.
inline AnalysisResult& result_of(AnalysisRun& run, const std::string& name) {
    for (AnalysisResult& result : run.results) {
        if (result.name == name) return result;
    }
    throw reference::Error::internal("no result " + name);
}

}  // namespace scotty::verify::test
