#include "verify/images/image_metrics.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "verify/images/flip.h"
#include "verify/images/srgb.h"

namespace scotty::verify {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Places floats in order on a line of integers, both zeros at 0.
std::int64_t place_of(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::int64_t size = bits & 0x7fffffffu;
    return (bits >> 31) != 0 ? -size : size;
}

bool all_finite(const MeasuredImage& image) {
    return std::all_of(image.mean.begin(), image.mean.end(), [](const Color& color) {
        return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]);
    });
}

double mean_of(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// Averages over all pixels and channels.
template <class Distance>
double mean_over_values(const MeasuredImage& a, const MeasuredImage& b, const Distance& distance) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.mean.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) sum += distance(a.mean[i][c], b.mean[i][c]);
    }
    return sum / (3.0 * static_cast<double>(a.mean.size()));
}

double encoded(double linear) { return srgb_encode(static_cast<float>(linear)); }

}  // namespace

double ulps_between(double a, double b) {
    const auto x = static_cast<float>(a);
    const auto y = static_cast<float>(b);
    if (std::isnan(x) || std::isnan(y)) return std::isnan(x) && std::isnan(y) ? 0.0 : kInfinite;
    return static_cast<double>(std::abs(place_of(x) - place_of(y)));
}

std::vector<double> ulps_map(const MeasuredImage& image, const MeasuredImage& golden) {
    std::vector<double> map(image.mean.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            map[i] = std::max(map[i], ulps_between(image.mean[i][c], golden.mean[i][c]));
        }
    }
    return map;
}

ImageMetrics image_metrics(const MeasuredImage& image, const MeasuredImage& golden) {
    ImageMetrics metrics;
    const std::vector<double> ulps = ulps_map(image, golden);
    metrics.max_ulps = *std::max_element(ulps.begin(), ulps.end());
    if (!all_finite(image) || !all_finite(golden)) {
        metrics.flip = metrics.rel_mse = metrics.psnr = std::nan("");
        return metrics;
    }
    metrics.flip = mean_of(flip_map(image, golden));
    metrics.rel_mse = mean_over_values(
        image, golden, [](double a, double b) { return (a - b) * (a - b) / (b * b + 0.01); });
    const double squares = mean_over_values(
        image, golden, [](double a, double b) { return std::pow(encoded(a) - encoded(b), 2); });
    metrics.psnr = squares > 0.0 ? -10.0 * std::log10(squares) : kInfinite;
    return metrics;
}

reference::Image heat_map(const std::vector<double>& values, std::uint32_t width,
                          std::uint32_t height, double most) {
    using reference::Vec3;
    static const std::array kColors{Vec3(0.0f), Vec3(0.05f, 0.05f, 0.6f), Vec3(0.8f, 0.05f, 0.1f),
                                    Vec3(1.0f, 0.8f, 0.1f), Vec3(1.0f)};
    reference::Image image{width, height, {}};
    image.pixels.reserve(values.size());
    for (const double value : values) {
        if (std::isnan(value)) {
            image.pixels.emplace_back(1.0f, 0.0f, 1.0f);
            continue;
        }
        const double place = std::clamp(value / most, 0.0, 1.0) * (kColors.size() - 1);
        const auto below = std::min(static_cast<std::size_t>(place), kColors.size() - 2);
        const auto share = static_cast<float>(place - static_cast<double>(below));
        image.pixels.push_back(kColors[below] * (1.0f - share) + kColors[below + 1] * share);
    }
    return image;
}

}  // namespace scotty::verify
