#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <string>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/verify/analysis_runs.h"
#include "verify/analysis/analysis_figures.h"
#include "verify/analysis/analysis_findings.h"
#include "verify/analysis/analysis_page.h"
#include "verify/pages/page.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;

std::vector<AnalysisPoint> power_law(double exponent) {
    std::vector<AnalysisPoint> points;
    for (const double x : {16.0, 64.0, 256.0, 1024.0}) {
        points.push_back(made_point(x, 3.0 * std::pow(x, exponent)));
    }
    return points;
}

TEST_CASE("analysis: the slope of a power law is its exponent", "[verify][analysis]") {
    CHECK(loglog_slope(power_law(1.0)).value() == Approx(1.0));
    CHECK(loglog_slope(power_law(0.7925)).value() == Approx(0.7925));
    CHECK(loglog_slope(power_law(-2.0)).value() == Approx(-2.0));
    // What the paper says of its own: four times the rays, three times the time.
    CHECK(loglog_slope({made_point(1, 1), made_point(4, 3)}).value() == Approx(0.79).epsilon(0.01));
}

TEST_CASE("analysis: wrong data has another slope, and data without a slope none",
          "[verify][analysis]") {
    std::vector<AnalysisPoint> wrong = power_law(0.7925);
    wrong.back().y *= 2.0;
    CHECK(std::abs(loglog_slope(wrong).value() - 0.7925) > 0.1);
    CHECK_FALSE(loglog_slope({}));
    CHECK_FALSE(loglog_slope({made_point(5, 1)}));
    CHECK_FALSE(loglog_slope({made_point(5, 1), made_point(5, 2)}));
    CHECK_THROWS_WITH(loglog_slope({made_point(5, 1), made_point(6, 0)}),
                      ContainsSubstring("positive"));
    CHECK_THROWS_WITH(
        loglog_slope({made_point(5, std::numeric_limits<double>::quiet_NaN()), made_point(6, 1)}),
        ContainsSubstring("positive"));
}

TEST_CASE("analysis: the file gives back what was measured", "[verify][analysis]") {
    const std::vector<AnalysisRun> runs{made_run("one"), made_run("two & three", 2.0)};
    const std::string text = to_json(runs).dump();
    const auto read = parse_analysis("a.json", json::parse(text));
    REQUIRE(read.size() == 2);
    CHECK(read[1].label == "two & three");
    CHECK(to_json(read).dump() == text);
    // And a file that was changed gives back something else.
    json changed = json::parse(text);
    changed["runs"][0]["analyses"][0]["series"][0]["points"][1]["y"] = 404.0;
    changed["runs"][0]["analyses"][0]["series"][0]["points"][1]["high"] = 405.0;
    CHECK(to_json(parse_analysis("a.json", changed)).dump() != text);
}

TEST_CASE("analysis: a file that is not what it should be is refused, and the place named",
          "[verify][analysis]") {
    const json good = json::parse(to_json({made_run("one")}).dump());
    const auto refused = [&](const char* pointer, const json& value) {
        json bad = good;
        bad[json::json_pointer(pointer)] = value;
        try {
            parse_analysis("a.json", bad);
        } catch (const scotty::reference::Error& error) {
            CHECK(error.kind() == scotty::reference::ErrorKind::bad_input);
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const std::string point = "/runs/0/analyses/0/series/0/points/1";
    CHECK_THAT(refused("/format", "scotty capture"), ContainsSubstring("scotty analysis"));
    CHECK_THAT(refused("/version", 99), ContainsSubstring("version"));
    CHECK_THAT(refused("/runs", 1), ContainsSubstring("'runs': not a list"));
    CHECK_THAT(
        refused("/runs/0/analyses/0/name", "nonsense"),
        ContainsSubstring("'nonsense' is no analysis") && ContainsSubstring("limited-blocks"));
    CHECK_THAT(refused((point + "/y").c_str(), nullptr),
               ContainsSubstring("rays, series '', point 1") &&
                   ContainsSubstring("'y': expected a finite number"));
    CHECK_THAT(refused((point + "/low").c_str(), 1e9), ContainsSubstring("low <= y <= high"));
    CHECK_THAT(refused("/runs/0/analyses/0/series/0/panel", 1u), ContainsSubstring("'panel'"));
    CHECK_THAT(refused("/runs/0/analyses/0/parameters/width", 3), ContainsSubstring("width"));
}

TEST_CASE("analysis: what is not finite is not written", "[verify][analysis]") {
    AnalysisRun run = made_run("one");
    result_of(run, "width").series[0].points[2].y = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(to_json({run}), ContainsSubstring("width") && ContainsSubstring("finite"));
}

TEST_CASE("analysis: a figure has every point that was measured and every one that is given",
          "[verify][analysis]") {
    const std::vector<AnalysisRun> runs{made_run("one"), made_run("two", 2.0)};
    for (const AnalysisDefinition& definition : analysis_catalog()) {
        std::size_t expected = 0;
        for (const AnalysisRun& run : runs) {
            for (const AnalysisSeries& series : run.find(definition.name)->series) {
                expected += series.points.size();
            }
        }
        for (const GivenSeries& given : definition.given) expected += given.points.size();
        pugi::xml_document document;
        INFO(definition.name);
        REQUIRE(document.load_string(figure(definition, runs).c_str()));
        CHECK(document.select_nodes("//*[starts-with(@class, 'point')]").size() == expected);
    }
}

TEST_CASE("analysis: values are drawn relative to what the panel says", "[verify][analysis]") {
    const std::vector<AnalysisPoint> points{made_point(1, 8), made_point(2, 4), made_point(3, 4)};
    CHECK(drawn(points, Relative::none)[0].y == 8.0);
    CHECK(drawn(points, Relative::to_least)[0].y == 2.0);
    CHECK(drawn(points, Relative::to_first)[1].y == 50.0);
    CHECK(drawn(points, Relative::share)[0].y == 50.0);
    CHECK(drawn(points, Relative::share)[0].high == Approx(55.0));
    CHECK(drawn({}, Relative::share).empty());
}

TEST_CASE("analysis: numbers of different places stand in their own rows", "[verify][analysis]") {
    const auto rows = numbers(analysis_named("", "rays-per-block"), 0, {made_run("one")});
    REQUIRE(rows.size() == 6);  // 32, 64 and 128, and the paper's 256 and 512
    CHECK(rows[0][1] == "one: ms a render");
    CHECK(rows[1][0] == "32");
    CHECK_THAT(rows[1][1], ContainsSubstring("6.2 (5.58 to 6.82)"));
    CHECK(rows[5][0] == "512");
    CHECK(rows[5][1].empty());
    CHECK(rows[5][2] == "31");
}

TEST_CASE("analysis: what is seen follows from the numbers", "[verify][analysis]") {
    AnalysisRun run = made_run("here");
    const auto found = [&](const std::string& name) { return finding(run, result_of(run, name)); };
    result_of(run, "rays").series[0].points = power_law(0.79);
    CHECK_THAT(found("rays"),
               ContainsSubstring("here: a slope of 0.79") && ContainsSubstring("as in the paper"));
    result_of(run, "rays").series[0].points = power_law(0.99);
    CHECK_THAT(found("rays"),
               ContainsSubstring("a slope of 0.99") && ContainsSubstring("where the paper has"));

    auto& widths = result_of(run, "width").series[0].points;
    widths = {made_point(2, 20), made_point(4, 10), made_point(8, 30), made_point(16, 40)};
    CHECK_THAT(found("width"),
               ContainsSubstring("fastest at 4") && ContainsSubstring("8, is slower here"));
    widths[2] = made_point(8, 10.5);
    CHECK_THAT(found("width"),
               ContainsSubstring("do not tell from 8") && ContainsSubstring("8, is as good"));

    auto& strided = result_of(run, "strided").series[1].points;
    CHECK_THAT(found("strided"),
               ContainsSubstring("1.00 times") && ContainsSubstring("next to nothing"));
    for (AnalysisPoint& point : strided) point.y *= 0.75;
    CHECK_THAT(found("strided"),
               ContainsSubstring("0.75 times") && ContainsSubstring("as in the paper"));
    for (AnalysisPoint& point : strided) point.y *= 2.0;
    CHECK_THAT(found("strided"), ContainsSubstring("1.50 times") && ContainsSubstring("cost time"));

    auto& queries = result_of(run, "bounces").series[0].points;
    queries[2].y = queries[0].y;
    CHECK_THAT(found("bounces"),
               ContainsSubstring("1.0 times that") && ContainsSubstring("as in the paper"));
    queries[2].y = 3.0 * queries[0].y;
    CHECK_THAT(found("bounces"),
               ContainsSubstring("3.0 times that") && ContainsSubstring("the paper has scattered"));

    result_of(run, "limited-blocks").series.pop_back();
    CHECK_THROWS_WITH(found("limited-blocks"),
                      ContainsSubstring("no series 'a block for every slot'"));
    queries[1].more.clear();
    CHECK_THROWS_WITH(found("bounces"), ContainsSubstring("no column 'rays'"));
    run = made_run("here");
    result_of(run, "memory").series[0].points.clear();
    CHECK_THAT(found("memory"), ContainsSubstring("a series is empty"));
    for (const AnalysisDefinition& definition : analysis_catalog()) {
        CHECK_THAT(found(definition.name), ContainsSubstring("here: "));
    }
}

TEST_CASE("analysis: the page has every analysis, fetches nothing, and escapes names",
          "[verify][analysis]") {
    const std::vector<AnalysisRun> runs{made_run("</p><script>alert(1)</script>")};
    const std::string page = analysis_page(runs);
    for (const AnalysisDefinition& definition : analysis_catalog()) {
        CHECK_THAT(page, ContainsSubstring("<section id=\"" + definition.name + "\""));
    }
    CHECK_THAT(page, ContainsSubstring("default-src 'none'") && !ContainsSubstring("<script") &&
                         !ContainsSubstring("src="));
    for (const auto& [name, text] : page_files()) {
        const bool style = name == "house.css" || name == "analysis.css";
        if (style) CHECK_THAT(page, ContainsSubstring(std::string(text)));
    }
    CHECK_THAT(analysis_text(runs),
               ContainsSubstring("Tree width (width)") && ContainsSubstring("fastest at"));
    AnalysisRun part = made_run("part");
    part.results.resize(1);
    CHECK_THAT(analysis_page({part}), !ContainsSubstring("<section id=\"width\""));
}

}  // namespace
