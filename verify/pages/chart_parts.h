/// Shared by lines and bars. All lengths are units of a drawing kChartWidth wide.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "verify/pages/chart.h"

namespace scotty::verify {

inline constexpr double kChartWidth = 560.0;
inline constexpr double kChartFont = 13.0;
inline constexpr double kChartRow = 17.0;  ///< from one line of text to the next

/// Maps values to positions, and places the ticks.
class ChartScale {
 public:
    /// Covers all `values`; `begin` and `end` are positions. Without values: 0 to 1, or 1 to 10.
    ChartScale(const ChartAxis& axis, std::vector<double> values, double begin, double end);

    double operator()(double value) const;
    const std::vector<double>& ticks() const { return ticks_; }

 private:
    double forward(double value) const;

    Scale scale_;
    double low_, high_, begin_, end_;
    std::vector<double> ticks_;
};

/// Throws bad_input naming the series and the first point that cannot be drawn.
void expect_finite(const std::vector<ChartSeries>& series);
void expect_positive(const std::vector<ChartSeries>& series, const ChartAxis& axis,
                     double ChartPoint::*value);

/// An estimate of the width in a reader's font, slightly too large.
double text_width(std::string_view text);
/// `anchor` is start, middle or end; `kind` a class of the style sheet, or empty.
std::string svg_text(double x, double y, std::string_view anchor, std::string_view kind,
                     std::string_view text);
/// "c0", "given"; colours repeat after the last.
std::string color_class(const ChartSeries& series);
/// The text that a reader sees when resting on a point.
std::string svg_title(const ChartSeries& series, const std::string& place, const ChartPoint& point);

}  // namespace scotty::verify
