/// Analyses as a file, so that one machine can draw what another has measured.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_catalog.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

using nlohmann::json;
using nlohmann::ordered_json;
using reference::Error;

namespace {

constexpr const char* kAnalysisFormat = "scotty analysis";
constexpr int kAnalysisVersion = 1;

ordered_json point_json(const AnalysisPoint& point, const std::string& where) {
    ordered_json out{{"x", point.x}, {"label", point.label}, {"y", point.y}, {"low", point.low}};
    out["high"] = point.high;
    ordered_json more = ordered_json::array();  // not an object, whose members have no order
    for (const auto& [name, value] : point.more) {
        more.push_back({{"name", name}, {"value", value}});
    }
    out["more"] = more;
    for (const double value : {point.x, point.y, point.low, point.high}) {
        if (!std::isfinite(value)) {
            throw Error::bad_input(where, fmt::format("expected finite numbers, found {} at {}{}",
                                                      value, point.x, point.label));
        }
    }
    return out;
}

ordered_json result_json(const AnalysisResult& result) {
    ordered_json all = ordered_json::array();
    for (const AnalysisSeries& series : result.series) {
        ordered_json points = ordered_json::array();
        for (const AnalysisPoint& point : series.points) {
            points.push_back(point_json(point, result.name + ", " + series.name));
        }
        all.push_back({{"panel", series.panel}, {"name", series.name}, {"points", points}});
    }
    return {{"name", result.name}, {"parameters", to_json(result.parameters)}, {"series", all}};
}

const json& array_member(const std::string& where, const json& object, const char* name) {
    const json& value = member(where, object, name);
    if (!value.is_array()) throw Error::bad_input(where, fmt::format("'{}': not a list", name));
    return value;
}

double number_member(const std::string& where, const json& object, const char* name) {
    const json& value = member(where, object, name);
    // A number that is too large reads as infinite.
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
        throw Error::bad_input(where, fmt::format("'{}': expected a finite number", name));
    }
    return value.get<double>();
}

AnalysisPoint parse_point(const std::string& where, const json& object) {
    AnalysisPoint point{number_member(where, object, "x"), text_member(where, object, "label"),
                        number_member(where, object, "y"), number_member(where, object, "low"),
                        number_member(where, object, "high")};
    if (point.low > point.y || point.high < point.y) {
        throw Error::bad_input(where, fmt::format("expected low <= y <= high, found {}, {}, {}",
                                                  point.low, point.y, point.high));
    }
    for (const json& each : array_member(where, object, "more")) {
        point.more.emplace_back(text_member(where, each, "name"),
                                number_member(where, each, "value"));
    }
    return point;
}

AnalysisResult parse_result(const std::string& file, const json& object) {
    AnalysisResult result;
    result.name = text_member(file, object, "name");
    const std::size_t panels = analysis_named(file, result.name).panels.size();
    const std::string where = file + ": " + result.name;
    result.parameters = parse_parameters(where, member(where, object, "parameters"));
    for (const json& each : array_member(where, object, "series")) {
        AnalysisSeries series;
        series.panel = unsigned_member(where, each, "panel", panels - 1);
        series.name = text_member(where, each, "name");
        const json& points = array_member(where, each, "points");
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::string place =
                fmt::format("{}, series '{}', point {}", where, series.name, i);
            series.points.push_back(parse_point(place, points[i]));
        }
        result.series.push_back(std::move(series));
    }
    return result;
}

}  // namespace

ordered_json to_json(const std::vector<AnalysisRun>& runs) {
    ordered_json all = ordered_json::array();
    for (const AnalysisRun& run : runs) {
        ordered_json results = ordered_json::array();
        for (const AnalysisResult& result : run.results) results.push_back(result_json(result));
        all.push_back({{"label", run.label},
                       {"backend", run.backend},
                       {"scene", run.scene},
                       {"triangles", run.triangles},
                       {"machine", run.machine},
                       {"machine_details", run.machine_details},
                       {"repeats", run.repeats},
                       {"analyses", results}});
    }
    return {{"format", kAnalysisFormat}, {"version", kAnalysisVersion}, {"runs", all}};
}

std::vector<AnalysisRun> parse_analysis(const std::filesystem::path& file, const json& object) {
    expect_format(file, object, kAnalysisFormat, kAnalysisVersion);
    const std::string where = file.string();
    std::vector<AnalysisRun> runs;
    for (const json& each : array_member(where, object, "runs")) {
        AnalysisRun run;
        run.label = text_member(where, each, "label");
        run.backend = text_member(where, each, "backend");
        run.scene = text_member(where, each, "scene");
        run.triangles = unsigned_member(where, each, "triangles", UINT64_MAX);
        run.machine = text_member(where, each, "machine");
        run.machine_details = member(where, each, "machine_details");
        run.repeats = static_cast<int>(unsigned_member(where, each, "repeats", 1000000));
        for (const json& result : array_member(where, each, "analyses")) {
            run.results.push_back(parse_result(where, result));
        }
        runs.push_back(std::move(run));
    }
    return runs;
}

}  // namespace scotty::verify
