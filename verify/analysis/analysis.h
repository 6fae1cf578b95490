/// What `scotty analyze` measures: the 2018 paper's analyses as series of points, and their file.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "reference/contract/pipeline_parameters.h"

namespace scotty::verify {

/// A place on an axis and the value found there.
struct AnalysisPoint {
    double x = 0.0;
    std::string label;  ///< of a category: "merge"; empty if x is the place
    double y = 0.0;     ///< the median if there are repeats
    /// The least and the most of the repeats; both equal y for a single value or a count.
    double low = 0.0, high = 0.0;
    /// More columns of the table, by name.
    std::vector<std::pair<std::string, double>> more{};

    /// Finds a column by its name; throws bad_input if it is missing, as a file may lack it.
    double column(const std::string& name) const;
};

struct AnalysisSeries {
    std::size_t panel = 0;  ///< of the definition's panels (analysis_catalog.h)
    std::string name;       ///< "width 4"; empty if an analysis has one series
    std::vector<AnalysisPoint> points;
};

/// One analysis, carried out.
struct AnalysisResult {
    std::string name;
    reference::PipelineParameters parameters;  ///< before the sweep changes one of them
    std::vector<AnalysisSeries> series;

    /// Throws bad_input if it is missing, as a file may lack it.
    const AnalysisSeries& named(std::size_t panel, const std::string& series_name) const;
};

/// All results of one machine for one scene.
struct AnalysisRun {
    std::string label;    ///< the name of its series: "emulator, 2 threads", "H100"
    std::string backend;  ///< by its name on the command line
    std::string scene;
    std::uint64_t triangles = 0;
    std::string machine;             ///< processor, device and build, in a line
    nlohmann::json machine_details;  ///< machine.h
    int repeats = 0;
    std::vector<AnalysisResult> results;

    /// Null if the analysis was not asked for.
    const AnalysisResult* find(const std::string& name) const;
};

/// Throws bad_input naming the series and the point that is not finite.
nlohmann::ordered_json to_json(const std::vector<AnalysisRun>& runs);
/// Reads what to_json() has written. Throws bad_input naming `file` and the element.
std::vector<AnalysisRun> parse_analysis(const std::filesystem::path& file,
                                        const nlohmann::json& object);

}  // namespace scotty::verify
