#include "verify/analysis/analysis.h"

#include "reference/base/error.h"

namespace scotty::verify {

using reference::Error;

double AnalysisPoint::column(const std::string& name) const {
    for (const auto& [each, value] : more) {
        if (each == name) return value;
    }
    throw Error::bad_input("analysis", "a point has no column '" + name + "'");
}

const AnalysisSeries& AnalysisResult::named(std::size_t panel,
                                            const std::string& series_name) const {
    for (const AnalysisSeries& one : series) {
        if (one.panel == panel && one.name == series_name) return one;
    }
    throw Error::bad_input("analysis", name + " has no series '" + series_name + "'");
}

const AnalysisResult* AnalysisRun::find(const std::string& name) const {
    for (const AnalysisResult& result : results) {
        if (result.name == name) return &result;
    }
    return nullptr;
}

}  // namespace scotty::verify
