#include <limits>
#include <pugixml.hpp>
#include <string>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "verify/pages/chart.h"
#include "verify/pages/chart_parts.h"

namespace {

using namespace scotty::verify;
using Catch::Matchers::ContainsSubstring;
using scotty::reference::Error;

ChartPoint at(double x, double y, const std::string& label = "") { return {x, y, y, y, label}; }

LineChart lines() {
    return {{"rays", Scale::log2},
            {"ms", Scale::log10},
            {{"ours", 0, LineStyle::line, {at(16, 1), at(64, 3), at(256, 10)}},
             {"theirs", kGivenColor, LineStyle::dashed, {at(16, 2), at(256, 9)}},
             {"slope 1", kGivenColor, LineStyle::guide, {at(16, 1), at(256, 16)}}}};
}

BarChart bars() {
    return {"percent",
            {{"ours", 0, LineStyle::line, {at(0, 60, "traversal"), at(0, 40, "merge")}},
             {"theirs", kGivenColor, LineStyle::dashed, {at(0, 80, "merge"), at(0, 5, "clear")}}}};
}

/// Markers or bars of points, as a reader of XML finds them; fails where that reader does.
std::size_t points_in(const std::string& svg) {
    pugi::xml_document document;
    const auto parsed = document.load_string(svg.c_str());
    INFO(svg);
    REQUIRE(parsed.description() == std::string("No error"));
    REQUIRE(document.child("svg"));
    return document.select_nodes("//*[starts-with(@class, 'point')]").size();
}

std::string document_of(const ChartPanel& panel) { return svg_document("a title", {panel}); }

TEST_CASE("chart: every point of every series is there, in well-formed XML", "[verify][chart]") {
    CHECK(points_in(document_of(draw(lines()))) == 5);  // a guide has none
    CHECK(points_in(document_of(draw(bars()))) == 4);
    CHECK(points_in(svg_document("both", {draw(lines()), draw(bars())})) == 9);
}

TEST_CASE("chart: a point that is left out, and a tag that is not closed, are noticed",
          "[verify][chart]") {
    LineChart fewer = lines();
    fewer.series[0].points.pop_back();
    CHECK(points_in(document_of(draw(fewer))) == 4);
    std::string open = document_of(draw(lines()));
    open.erase(open.find("</text>"), 7);
    pugi::xml_document document;
    CHECK_FALSE(document.load_string(open.c_str()));
}

TEST_CASE("chart: text cannot end an element or begin one", "[verify][chart]") {
    LineChart chart = lines();
    chart.series[0].name = "</text><script>\"&'\x01";
    BarChart categories = bars();
    categories.series[0].points[0].label = "<b>&\x1b";
    for (const std::string& svg : {svg_document("a < b & \"c\"", {draw(chart)}),
                                   svg_document("</svg>", {draw(categories)})}) {
        points_in(svg);
        CHECK_THAT(svg, !ContainsSubstring("<script>") && !ContainsSubstring("<b>") &&
                            !ContainsSubstring("\x01"));
        CHECK_THAT(svg, !ContainsSubstring("\x1b"));
    }
}

TEST_CASE("chart: empty charts, empty series and single points are drawn", "[verify][chart]") {
    for (const Scale scale : {Scale::linear, Scale::log2, Scale::log10}) {
        LineChart chart{{"x", scale}, {"y", scale}, {}};
        CHECK(points_in(document_of(draw(chart))) == 0);
        chart.series.push_back({"empty", 0, LineStyle::line, {}});
        CHECK(points_in(document_of(draw(chart))) == 0);
        chart.series.push_back({"one", 1, LineStyle::line, {at(5, 7)}});
        const std::string svg = document_of(draw(chart));
        CHECK(points_in(svg) == 1);
        CHECK_THAT(svg, !ContainsSubstring("nan") && !ContainsSubstring("inf"));
    }
    CHECK(points_in(document_of(draw(BarChart{"y", {}}))) == 0);
    CHECK(points_in(document_of(draw(BarChart{"y", {{"zero", 0, {}, {at(0, 0, "a")}}}}))) == 1);
    CHECK(points_in(svg_document("nothing", {})) == 0);
}

TEST_CASE("chart: what is not finite is refused, and named", "[verify][chart]") {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        LineChart chart = lines();
        chart.series[1].points[1].y = bad;
        CHECK_THROWS_WITH(draw(chart),
                          ContainsSubstring("series 'theirs'") && ContainsSubstring("point 1"));
        BarChart bar = bars();
        bar.series[0].points[1].high = bad;
        CHECK_THROWS_WITH(draw(bar),
                          ContainsSubstring("series 'ours'") && ContainsSubstring("point 1"));
    }
}

TEST_CASE("chart: a logarithmic axis refuses zero, and a bar what is below", "[verify][chart]") {
    LineChart chart = lines();
    chart.series[0].points[2].y = 0.0;
    CHECK_THROWS_WITH(draw(chart),
                      ContainsSubstring("series 'ours'") && ContainsSubstring("logarithmic"));
    chart.y.scale = Scale::linear;
    CHECK_NOTHROW(draw(chart));
    BarChart bar = bars();
    bar.series[1].points[0].y = -1.0;
    CHECK_THROWS_AS(draw(bar), Error);
}

TEST_CASE("chart: positions follow the scale, and ticks are round", "[verify][chart]") {
    const ChartScale linear({"", Scale::linear}, {0.0, 10.0}, 0.0, 100.0);
    CHECK(linear(2.5) == Approx(25.0));
    CHECK(linear.ticks() == std::vector<double>{0, 2, 4, 6, 8, 10});
    const ChartScale two({"", Scale::log2}, {2.0, 16.0}, 0.0, 90.0);
    CHECK(two(4.0) == Approx(30.0));
    CHECK(two.ticks() == std::vector<double>{2, 4, 8, 16});
    const ChartScale ten({"", Scale::log10}, {1.0, 1000.0}, 300.0, 0.0);
    CHECK(ten(10.0) == Approx(200.0));
    CHECK(ten.ticks().size() == 4);
    const ChartScale short_one({"", Scale::log10}, {30.0, 61.0}, 0.0, 1.0);
    CHECK(short_one.ticks() == std::vector<double>{30, 40, 50});
    const ChartScale zero({"", Scale::linear, true}, {5.0, 10.0}, 0.0, 100.0);
    CHECK(zero(5.0) == Approx(50.0));
}

TEST_CASE("chart: numbers are written short", "[verify][chart]") {
    CHECK(short_number(0) == "0");
    CHECK(short_number(0.79249) == "0.79");
    CHECK(short_number(5) == "5");
    CHECK(short_number(28.04) == "28");
    CHECK(short_number(61.25) == "61.2");
    CHECK(short_number(1024) == "1024");
    CHECK(short_number(65536) == "65.5k");
    CHECK(short_number(1048576) == "1.05M");
    CHECK(short_number(6e9) == "6G");
    CHECK(short_number(0.00123) == "0.0012");
}

}  // namespace
