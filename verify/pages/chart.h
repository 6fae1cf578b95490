/// Lines and bars as SVG, for analyses. They are light or dark by the reader's preference, use no
/// script, fetch nothing, and are legible at 420 pixels.
#pragma once

#include <string>
#include <vector>

namespace scotty::verify {

struct ChartPoint {
    double x = 0.0, y = 0.0;
    double low = 0.0, high = 0.0;  ///< the ends of a whisker; both y: no whisker
    std::string label;             ///< of a category, for bars
};

enum class LineStyle {
    line,    ///< with a marker at each point
    dashed,  ///< the same, for the second of a pair
    guide    ///< thin, without markers: a line to compare with
};

struct ChartSeries {
    std::string name;  ///< written beside the end of the line; may be empty
    int color = 0;     ///< 0, 1, ... and kGivenColor
    LineStyle style = LineStyle::line;
    std::vector<ChartPoint> points;
};
/// Grey, for values that were not measured here.
inline constexpr int kGivenColor = -1;

enum class Scale { linear, log2, log10 };

struct ChartAxis {
    std::string label;
    Scale scale = Scale::linear;
    bool from_zero = false;  ///< for a linear axis: it includes zero
};

/// Series over a number.
struct LineChart {
    ChartAxis x, y;
    std::vector<ChartSeries> series;
};

/// Series over categories: ChartPoint::label, in the order in which they first appear. Bars begin
/// at zero.
struct BarChart {
    std::string label;  ///< of the values
    std::vector<ChartSeries> series;
};

struct ChartPanel {
    std::string svg;
    double height = 0.0;
};

/// Both throw bad_input naming series and point if a value is not finite, not positive on a
/// logarithmic axis, or a bar is negative.
ChartPanel draw(const LineChart& chart);
ChartPanel draw(const BarChart& chart);

/// Panels below each other as one file, or as an element of a page. Screen readers read the title;
/// it is not shown.
std::string svg_document(const std::string& title, const std::vector<ChartPanel>& panels);

/// Three digits: "65.5k", "0.42", "1.2M".
std::string short_number(double value);

}  // namespace scotty::verify
