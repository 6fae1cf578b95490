/// Axes: the map from values to positions, and round numbers for the ticks.
#include <algorithm>
#include <cmath>

#include "verify/pages/chart_parts.h"

namespace scotty::verify {
namespace {

constexpr int kTicks = 5;  ///< the approximate number

/// 1, 2 or 5 times a power of ten, at least `step`.
double round_step(double step) {
    const double power = std::pow(10.0, std::floor(std::log10(step)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= step * (1.0 - 1e-9)) return factor * power;
    }
    return 10.0 * power;
}

std::vector<double> linear_ticks(double low, double high) {
    const double step = round_step((high - low) / kTicks);
    std::vector<double> ticks;
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1.0) {
        ticks.push_back(i * step + 0.0);  // never -0
    }
    return ticks;
}

/// Powers of two; every second or fourth if there are many.
std::vector<double> binary_ticks(double low, double high) {
    const double first = std::ceil(std::log2(low) - 1e-9);
    const double last = std::floor(std::log2(high) + 1e-9);
    double step = 1.0;
    while ((last - first) / step > kTicks + 1) step *= 2.0;
    std::vector<double> ticks;
    for (double power = first; power <= last; power += step) ticks.push_back(std::exp2(power));
    return ticks;
}

/// Powers of ten, with values between them if there are fewer than three.
std::vector<double> decimal_ticks(double low, double high) {
    const auto between = [&](std::initializer_list<double> factors) {
        std::vector<double> ticks;
        for (double p = std::floor(std::log10(low)); p <= std::log10(high) + 1e-9; p += 1.0) {
            for (const double factor : factors) {
                const double tick = factor * std::pow(10.0, p);
                if (tick >= low * (1.0 - 1e-9) && tick <= high * (1.0 + 1e-9))
                    ticks.push_back(tick);
            }
        }
        return ticks;
    };
    std::vector<double> ticks = between({1.0});
    if (ticks.size() < 3) ticks = between({1.0, 2.0, 5.0});
    if (ticks.size() < 3) ticks = between({1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0});
    return ticks;
}

}  // namespace

ChartScale::ChartScale(const ChartAxis& axis, std::vector<double> values, double begin, double end)
    : scale_(axis.scale), begin_(begin), end_(end) {
    if (axis.from_zero && scale_ == Scale::linear) values.push_back(0.0);
    if (values.empty()) values = {1.0};
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    low_ = *least;
    high_ = *most;
    if (low_ == high_) {  // one value: leave room on both sides
        const double room = scale_ == Scale::linear ? std::max(std::abs(low_), 1.0) * 0.5 : 0.0;
        low_ = scale_ == Scale::linear ? low_ - room : low_ / 2.0;
        high_ = scale_ == Scale::linear ? high_ + room : high_ * 2.0;
    }
    ticks_ = scale_ == Scale::linear ? linear_ticks(low_, high_)
             : scale_ == Scale::log2 ? binary_ticks(low_, high_)
                                     : decimal_ticks(low_, high_);
}

double ChartScale::forward(double value) const {
    return scale_ == Scale::linear ? value : std::log2(value);
}

double ChartScale::operator()(double value) const {
    const double part = (forward(value) - forward(low_)) / (forward(high_) - forward(low_));
    return begin_ + part * (end_ - begin_);
}

}  // namespace scotty::verify
