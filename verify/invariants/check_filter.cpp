/// Recomputes the image filters by plain loops in double.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "verify/invariants/check_state.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Filter;
using reference::StageView;
using reference::Vec3;

namespace {

/// The rounding of a sum of 25 products in float, with a polynomial for the exponential.
constexpr double kRounding = 1.0e-5;
/// Weights below e^-87 are zero in float (reference/numerics/exponential.h): 25 of them at most,
/// each of the brightest value.
constexpr double kUnderflow = 25.0 * 0x1p-125;

struct Window {
    std::span<const Vec3> image;
    int width, height;

    /// The pixel there; beyond an edge, the nearest pixel of the image.
    const Vec3& at(int x, int y) const {
        const int column = std::clamp(x, 0, width - 1);
        const int row = std::clamp(y, 0, height - 1);
        return image[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(column)];
    }
};

using Pixel = std::array<double, 3>;

double brightest(std::span<const Vec3> image) {
    double most = 0.0;
    for (const Vec3& value : image) {
        const auto one = static_cast<double>(reference::max_abs(value));
        if (std::isfinite(one)) most = std::max(most, one);
    }
    return most;
}

Pixel median(const Window& window, int x, int y) {
    Pixel result{};
    for (int c = 0; c < 3; ++c) {
        std::array<float, 9> values{};
        for (int i = 0; i < 9; ++i) {
            values[static_cast<std::size_t>(i)] = window.at(x + i % 3 - 1, y + i / 3 - 1)[c];
        }
        std::sort(values.begin(), values.end());
        result[static_cast<std::size_t>(c)] = double{values[4]};
    }
    return result;
}

/// Weights fall off by distance and, in the bilateral filter, by the difference of radiance from
/// the centre: a quarter of the centre's largest channel plus 0.02 is one standard deviation.
Pixel weighted(const Window& window, int x, int y, bool bilateral) {
    const Vec3& centre = window.at(x, y);
    const double sigma = 0.25 * double{reference::max_abs(centre)} + 0.02;
    Pixel sum{};
    double weights = 0.0;
    for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
            const Vec3& value = window.at(x + dx, y + dy);
            double apart = dx * dx + dy * dy;
            for (int c = 0; bilateral && c < 3; ++c) {
                const double difference = (double{value[c]} - double{centre[c]}) / sigma;
                apart += difference * difference;
            }
            const double weight = std::exp(-0.5 * apart);
            for (int c = 0; c < 3; ++c) {
                sum[static_cast<std::size_t>(c)] += weight * double{value[c]};
            }
            weights += weight;
        }
    }
    for (double& channel : sum) channel /= weights;
    return sum;
}

}  // namespace

void check_filter(CheckState& state, const StageView& stage) {
    const auto& p = state.parameters;
    const std::size_t pixels = std::size_t{p.image_width} * p.image_height;
    const auto image = expect_buffer(state, stage, buffers::image, pixels);
    const auto filtered = expect_buffer(state, stage, buffers::filtered, pixels);
    if (image.size() != pixels || filtered.size() != pixels) return;
    const Window window{image, static_cast<int>(p.image_width), static_cast<int>(p.image_height)};
    const bool selects = p.filter == Filter::median;  // one of the image's own values
    const double rounding = selects ? 0.0 : kRounding;
    const double underflow = selects ? 0.0 : kUnderflow * brightest(image);
    for (std::size_t i = 0; i < pixels; ++i) {
        const int x = static_cast<int>(i % p.image_width);
        const int y = static_cast<int>(i / p.image_width);
        const Pixel expected =
            selects ? median(window, x, y) : weighted(window, x, y, p.filter == Filter::bilateral);
        for (int c = 0; c < 3; ++c) {
            const double wanted = expected[static_cast<std::size_t>(c)];
            const auto found = double{filtered[i][c]};
            // NaN is not near anything, and radiance has no negative zero.
            if (std::abs(found - wanted) <= rounding * std::abs(wanted) + underflow &&
                (found != 0.0 || !std::signbit(found))) {
                continue;
            }
            Failure failure =
                failure_at(stage, invariant::kFilter, "a pixel is not what the filter gives");
            failure.field = fmt::format("filtered[{}] (x {}, y {}), channel {}", i, x, y, c);
            failure.expected = fmt::format("{:.9g}", wanted);
            failure.found = fmt::format("{:.9g}", found);
            state.add(std::move(failure));
            return;
        }
    }
}

}  // namespace scotty::verify
