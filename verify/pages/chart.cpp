#include "verify/pages/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reference/base/error.h"
#include "verify/pages/chart_parts.h"
#include "verify/pages/page.h"

namespace scotty::verify {
namespace {

constexpr int kColors = 4;

// Red is for failures. The four also differ in lightness, for readers who do not see the hue.
constexpr const char* kChartStyle = R"(<style>
.chart { color-scheme: light dark; font: 13px system-ui, sans-serif; fill: #1f2124; --c0: #2d5f8f; --c1: #b8660a; --c2: #2e8b7a; --c3: #8a5aa8;
  --given: #7d8187; --grid: #e3e3df; --quiet: #63676d; }
@media (prefers-color-scheme: dark) {
  .chart { fill: #dfe1e4; --c0: #8cb6e2; --c1: #e7a255; --c2: #6cc7b4; --c3: #c39ae0; --given: #8d929a; --grid: #2c2f34;
    --quiet: #989da5; }
}
.chart .quiet { fill: var(--quiet); }
.chart .grid { stroke: var(--grid); }
.chart .c0 { --c: var(--c0); } .chart .c1 { --c: var(--c1); } .chart .c2 { --c: var(--c2); } .chart .c3 { --c: var(--c3); }
.chart .given { --c: var(--given); }
.chart path { fill: none; stroke: var(--c); stroke-width: 2; }
.chart path.dashed { stroke-dasharray: 6 4; }
.chart path.guide { stroke-width: 1; stroke-dasharray: 1.5 3; }
.chart .whisker { stroke: var(--c); opacity: .6; }
.chart .inside { stroke: Canvas; }
.chart .leader { stroke: var(--c); stroke-width: .75; opacity: .6; }
.chart circle, .chart rect { fill: var(--c); }
.chart rect.dashed { opacity: .5; }
.chart circle.dashed { fill: Canvas; stroke: var(--c); stroke-width: 1.5; }
.chart text.name { fill: var(--c); }
.chart text.name.given { fill: var(--quiet); }
</style>
)";

}  // namespace

void expect_finite(const std::vector<ChartSeries>& series) {
    for (const ChartSeries& one : series) {
        for (std::size_t i = 0; i < one.points.size(); ++i) {
            const ChartPoint& p = one.points[i];
            for (const double value : {p.x, p.y, p.low, p.high}) {
                if (std::isfinite(value)) continue;
                throw reference::Error::bad_input(
                    "series '" + one.name + "'",
                    fmt::format("point {}: {} cannot be drawn", i, value));
            }
        }
    }
}

void expect_positive(const std::vector<ChartSeries>& series, const ChartAxis& axis,
                     double ChartPoint::*value) {
    if (axis.scale == Scale::linear) return;
    for (const ChartSeries& one : series) {
        for (std::size_t i = 0; i < one.points.size(); ++i) {
            if (one.points[i].*value > 0.0) continue;
            throw reference::Error::bad_input(
                "series '" + one.name + "'",
                fmt::format("point {}: {} is not on a logarithmic axis", i, one.points[i].*value));
        }
    }
}

std::string short_number(double value) {
    const double size = std::abs(value);
    const auto scaled = [&](double unit, const char* suffix) {
        const double part = value / unit;
        // "262k" and "1.05M", but "1M" for round values.
        const int digits = std::abs(part) < 9.995 ? 2 : std::abs(part) < 99.95 ? 1 : 0;
        std::string text = fmt::format("{:.{}f}", part, digits);
        if (digits > 0) {
            text.erase(text.find_last_not_of('0') + 1);
            if (text.back() == '.') text.pop_back();
        }
        return text + suffix;
    };
    if (size >= 999.5e6) return scaled(1e9, "G");
    if (size >= 999.5e3) return scaled(1e6, "M");
    if (size >= 9999.5) return scaled(1e3, "k");
    if (size >= 0.0995 || size == 0.0) return scaled(1.0, "");
    return fmt::format("{:.2g}", value);
}

double text_width(std::string_view text) {
    return 0.61 * kChartFont * static_cast<double>(text.size());
}

std::string svg_text(double x, double y, std::string_view anchor, std::string_view kind,
                     std::string_view text) {
    std::string plain(text);  // XML cannot express control characters, not even escaped
    std::replace_if(
        plain.begin(), plain.end(), [](unsigned char c) { return c < 0x20; }, ' ');
    return fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\">{}</text>\n", x, y, anchor,
        kind, html_text(plain));
}

std::string color_class(const ChartSeries& series) {
    return series.color == kGivenColor ? "given" : fmt::format("c{}", series.color % kColors);
}

std::string svg_title(const ChartSeries& series, const std::string& place,
                      const ChartPoint& point) {
    std::string text = fmt::format("{}{}{}: {}", series.name, series.name.empty() ? "" : ", ",
                                   place, short_number(point.y));
    if (point.low != point.high) {
        text += fmt::format(" ({} to {})", short_number(point.low), short_number(point.high));
    }
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
    return "<title>" + html_text(text) + "</title>";
}

std::string svg_document(const std::string& title, const std::vector<ChartPanel>& panels) {
    double height = 0.0;
    std::string body;
    for (const ChartPanel& panel : panels) {
        body += fmt::format("<g transform=\"translate(0 {:.1f})\">\n{}</g>\n", height, panel.svg);
        height += panel.height;
    }
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" class=\"chart\" "
        "role=\"img\" aria-label=\"{}\">\n{}{}</svg>\n",
        kChartWidth, std::max(height, 1.0), html_text(title), kChartStyle, body);
}

}  // namespace scotty::verify
