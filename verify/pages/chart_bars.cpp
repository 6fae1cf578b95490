/// Horizontal bars, so that long names fit, each with its value; grouped by category.
#include <fmt/format.h>

#include <algorithm>

#include "reference/base/error.h"
#include "verify/pages/chart_parts.h"

namespace scotty::verify {
namespace {

constexpr double kBar = 15.0;
constexpr double kBetweenGroups = 9.0;
constexpr double kValue = 52.0;  ///< room for a value behind the longest bar

std::vector<std::string> categories(const BarChart& chart) {
    std::vector<std::string> names;
    for (const ChartSeries& one : chart.series) {
        for (const ChartPoint& p : one.points) {
            if (std::find(names.begin(), names.end(), p.label) == names.end()) {
                names.push_back(p.label);
            }
        }
    }
    return names;
}

const char* shade(const ChartSeries& series) {
    return series.style == LineStyle::dashed ? " dashed" : "";
}

std::string whisker(const char* kind, double from, double to, double y) {
    return fmt::format(
        "<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kind,
        from, y, to, y);
}

class BarDrawing {
 public:
    explicit BarDrawing(const BarChart& chart) : chart_(chart) {
        for (const std::string& name : categories(chart)) {
            left_ = std::max(left_, text_width(name) + 10.0);
        }
        for (const ChartSeries& one : chart.series) {
            for (const ChartPoint& p : one.points) longest_ = std::max(longest_, p.high);
        }
    }

    ChartPanel draw() {
        svg_ += svg_text(4.0, 16.0, "start", "", chart_.label);
        draw_key();
        for (const std::string& name : categories(chart_)) draw_group(name);
        return {svg_, y_ + 14.0};
    }

 private:
    /// Draws the colours' names, on several lines if needed; nothing for one series without a name.
    void draw_key() {
        double x = 4.0;
        bool any = false;
        for (const ChartSeries& one : chart_.series) {
            if (one.name.empty()) continue;
            const double width = 16.0 + text_width(one.name) + 14.0;
            if (any && x + width > kChartWidth) {
                x = 4.0;
                y_ += kChartRow;
            }
            svg_ += fmt::format(
                "<g class=\"{}\"><rect class=\"key{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"11\" "
                "height=\"11\"/></g>\n",
                color_class(one), shade(one), x, y_);
            svg_ += svg_text(x + 16.0, y_ + 10.5, "start", "name " + color_class(one), one.name);
            x += width;
            any = true;
        }
        if (any) y_ += kChartRow + 8.0;
    }

    void draw_group(const std::string& name) {
        const double begin = y_;
        for (const ChartSeries& one : chart_.series) {
            for (const ChartPoint& p : one.points) {
                if (p.label != name) continue;
                draw_bar(one, p);
                y_ += kBar;
            }
        }
        svg_ += svg_text(left_ - 8.0, (begin + y_) / 2.0 + 4.0, "end", "", name);
        y_ += kBetweenGroups;
    }

    void draw_bar(const ChartSeries& one, const ChartPoint& p) {
        const double unit = (kChartWidth - left_ - kValue) / (longest_ > 0.0 ? longest_ : 1.0);
        const double middle = y_ + kBar / 2.0;
        svg_ += fmt::format(
            "<g class=\"{}\"><rect class=\"point{}\" x=\"{:.1f}\" y=\"{:.1f}\" "
            "width=\"{:.1f}\" height=\"{:.1f}\">{}</rect>\n",
            color_class(one), shade(one), left_, y_ + 1.0, std::max(p.y * unit, 0.5), kBar - 2.0,
            svg_title(one, p.label, p));
        const double end = left_ + p.y * unit;
        if (p.low != p.high) {
            svg_ += whisker("inside", left_ + p.low * unit, end, middle);
            svg_ += whisker("whisker", end, left_ + p.high * unit, middle);
        }
        svg_ += "</g>\n" + svg_text(left_ + p.high * unit + 5.0, middle + 4.0, "start", "quiet",
                                    short_number(p.y));
    }

    const BarChart& chart_;
    double left_ = 4.0;
    double longest_ = 0.0;
    double y_ = 28.0;
    std::string svg_;
};

}  // namespace

ChartPanel draw(const BarChart& chart) {
    expect_finite(chart.series);
    for (const ChartSeries& one : chart.series) {
        for (const ChartPoint& p : one.points) {
            if (p.y >= 0.0) continue;
            throw reference::Error::bad_input(
                "series '" + one.name + "'",
                fmt::format("{}: {} has no bar, which begins at zero", p.label, p.y));
        }
    }
    return BarDrawing(chart).draw();
}

}  // namespace scotty::verify
