/// Series over a number, each named beside its end.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verify/pages/chart_parts.h"

namespace scotty::verify {
namespace {

constexpr double kTop = 34.0;      ///< room for the name of the y axis
constexpr double kPlot = 210.0;    ///< height between the axes
constexpr double kBottom = 52.0;   ///< ticks and name of the x axis
constexpr double kLeft = 52.0;     ///< ticks of the y axis
constexpr double kToLabel = 12.0;  ///< from the last point to the name of its series
constexpr double kMarker = 3.5;

/// The name of a series, and the end of its line.
struct EndLabel {
    const ChartSeries* series;
    double x, y;      ///< of the last point
    double at = 0.0;  ///< the position of the text's middle
};

/// Spreads labels from top to bottom without overlap, within the plot if they fit.
void spread(std::vector<EndLabel>& labels, double top, double bottom) {
    std::sort(labels.begin(), labels.end(),
              [](const EndLabel& a, const EndLabel& b) { return a.y < b.y; });
    double least = top;
    for (EndLabel& label : labels) {
        label.at = std::max(label.y, least);
        least = label.at + kChartRow;
    }
    double most = bottom;
    for (std::size_t i = labels.size(); i-- > 0;) {
        labels[i].at = std::min(labels[i].at, most);
        most = labels[i].at - kChartRow;
    }
}

class LineDrawing {
 public:
    explicit LineDrawing(const LineChart& chart)
        : chart_(chart),
          right_(right_edge()),
          x_(chart.x, values(&ChartPoint::x, &ChartPoint::x), kLeft + 8.0, right_ - 4.0),
          y_(chart.y, values(&ChartPoint::low, &ChartPoint::high), kTop + kPlot, kTop + 4.0) {}

    ChartPanel draw() {
        draw_axes();
        // Ours come last, and so on top of the given ones.
        for (const bool given : {true, false}) {
            for (const ChartSeries& one : chart_.series) {
                if ((one.color == kGivenColor) == given) draw_series(one);
            }
        }
        draw_names();
        return {svg_, kTop + kPlot + kBottom};
    }

 private:
    double right_edge() const {
        double widest = 0.0;
        for (const ChartSeries& one : chart_.series) {
            widest = std::max(widest, text_width(one.name));
        }
        return std::max(kChartWidth * 0.4, kChartWidth - widest - kToLabel - 4.0);
    }

    std::vector<double> values(double ChartPoint::*low, double ChartPoint::*high) const {
        std::vector<double> all;
        for (const ChartSeries& one : chart_.series) {
            for (const ChartPoint& p : one.points) {
                all.push_back(p.*low);
                all.push_back(p.*high);
            }
        }
        return all;
    }

    void draw_axes() {
        for (const double tick : y_.ticks()) {
            svg_ += fmt::format(
                "<line class=\"grid\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n",
                kLeft, y_(tick), right_, y_(tick));
            svg_ += svg_text(kLeft - 8.0, y_(tick) + 4.5, "end", "quiet", short_number(tick));
        }
        const double below = kTop + kPlot + 20.0;
        for (const double tick : x_.ticks()) {
            svg_ += svg_text(x_(tick), below, "middle", "quiet", short_number(tick));
        }
        svg_ += svg_text(kLeft + 8.0, below + 19.0, "start", "", chart_.x.label);
        svg_ += svg_text(4.0, 16.0, "start", "", chart_.y.label);
    }

    void draw_series(const ChartSeries& one) {
        const char* style = one.style == LineStyle::guide    ? " guide"
                            : one.style == LineStyle::dashed ? " dashed"
                                                             : "";
        svg_ += fmt::format("<g class=\"{}\">\n", color_class(one));
        std::string path;
        for (const ChartPoint& p : one.points) {
            path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_(p.x), y_(p.y));
        }
        if (one.points.size() > 1) {
            svg_ += fmt::format("<path class=\"series{}\" d=\"{}\"/>\n", style, path);
        }
        if (one.style != LineStyle::guide) {
            for (const ChartPoint& p : one.points) draw_point(one, p, style);
        }
        svg_ += "</g>\n";
    }

    void draw_point(const ChartSeries& one, const ChartPoint& p, const char* style) {
        if (p.low != p.high) {
            svg_ += fmt::format(
                "<line class=\"whisker\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" "
                "y2=\"{2:.1f}\"/>\n",
                x_(p.x), y_(p.low), y_(p.high));
        }
        svg_ += fmt::format(
            "<circle class=\"point{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\">{}"
            "</circle>\n",
            style, x_(p.x), y_(p.y), kMarker, svg_title(one, short_number(p.x), p));
    }

    void draw_names() {
        std::vector<EndLabel> labels;
        for (const ChartSeries& one : chart_.series) {
            if (one.name.empty() || one.points.empty()) continue;
            const ChartPoint& last = one.points.back();
            labels.push_back({&one, x_(last.x), y_(last.y)});
        }
        spread(labels, kTop + 4.0, kTop + kPlot);
        for (const EndLabel& label : labels) {
            const double from = label.x + kMarker + 2.0;
            const double to = right_ + kToLabel - 4.0;
            if (to - from > kToLabel || std::abs(label.at - label.y) > 3.0) {
                svg_ += fmt::format(
                    "<g class=\"{}\"><line class=\"leader\" x1=\"{:.1f}\" y1=\"{:.1f}\" "
                    "x2=\"{:.1f}\" y2=\"{:.1f}\"/></g>\n",
                    color_class(*label.series), from, label.y, to, label.at);
            }
            svg_ += svg_text(right_ + kToLabel, label.at + 4.5, "start",
                             "name " + color_class(*label.series), label.series->name);
        }
    }

    const LineChart& chart_;
    double right_;
    ChartScale x_, y_;
    std::string svg_;
};

}  // namespace

ChartPanel draw(const LineChart& chart) {
    expect_finite(chart.series);
    expect_positive(chart.series, chart.x, &ChartPoint::x);
    expect_positive(chart.series, chart.y, &ChartPoint::low);
    expect_positive(chart.series, chart.y, &ChartPoint::y);
    return LineDrawing(chart).draw();
}

}  // namespace scotty::verify
