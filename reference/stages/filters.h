/// Stage filter for one pixel. Edges are extended: beyond one, the nearest pixel of the image
/// counts.
#pragma once

#include <cstdint>

#include "reference/base/host_device.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/views.h"
#include "reference/numerics/exponential.h"

namespace scotty::reference {

/// Standard deviations of the bilateral filter: one pixel in space; in radiance this share of the
/// centre pixel's largest channel plus a floor, so that exposure does not change what is an edge.
constexpr float kBilateralRange = 0.25f;
constexpr float kBilateralFloor = 0.02f;

/// The nearest coordinate of an image of this size.
SCOTTY_STAGE int inside(int value, std::uint32_t size) {
    return value < 0 ? 0 : (value >= static_cast<int>(size) ? static_cast<int>(size) - 1 : value);
}

/// The pixel at an offset.
SCOTTY_STAGE Vec3 pixel_at(const FilterView& view, std::uint32_t pixel, int dx, int dy) {
    const int x = inside(static_cast<int>(pixel % view.width) + dx, view.width);
    const int y = inside(static_cast<int>(pixel / view.width) + dy, view.height);
    return view.image[static_cast<std::size_t>(y) * view.width + static_cast<std::size_t>(x)];
}

/// Weighted mean of 5 x 5 pixels: a Gaussian of the distance and, where `bilateral`, of the
/// difference of radiance from the centre (Tomasi and Manduchi 1998).
SCOTTY_STAGE Vec3 weighted_mean(const FilterView& view, std::uint32_t pixel, bool bilateral) {
    const Vec3 centre = view.image[pixel];
    const float sigma = kBilateralRange * max_abs(centre) + kBilateralFloor;
    Vec3 sum(0.0f, 0.0f, 0.0f);
    float weights = 0.0f;
    for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
            const Vec3 value = pixel_at(view, pixel, dx, dy);
            const Vec3 difference = value - centre;
            const float range = bilateral ? dot(difference, difference) / (sigma * sigma) : 0.0f;
            const float weight = exp_minus(0.5f * (static_cast<float>(dx * dx + dy * dy) + range));
            sum += value * weight;
            weights += weight;
        }
    }
    return sum / weights;  // the centre weighs 1, so this is never 0 / 0
}

/// The 5th smallest of nine values; reorders them.
SCOTTY_STAGE float median_of_nine(float (&values)[9]) {
    for (int i = 0; i <= 4; ++i) {
        int least = i;
        for (int j = i + 1; j < 9; ++j) {
            if (values[j] < values[least]) least = j;
        }
        const float value = values[least];
        values[least] = values[i];
        values[i] = value;
    }
    return values[4];
}

/// Median of 3 x 3 pixels, each channel for itself.
SCOTTY_STAGE Vec3 median(const FilterView& view, std::uint32_t pixel) {
    float channels[3][9];
    int i = 0;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx, ++i) {
            const Vec3 value = pixel_at(view, pixel, dx, dy);
            channels[0][i] = value.x;
            channels[1][i] = value.y;
            channels[2][i] = value.z;
        }
    }
    return {median_of_nine(channels[0]), median_of_nine(channels[1]), median_of_nine(channels[2])};
}

/// `filter` is not none.
SCOTTY_STAGE void filter_pixel(const FilterView& view, Filter filter, std::uint32_t pixel) {
    view.filtered[pixel] = filter == Filter::median
                               ? median(view, pixel)
                               : weighted_mean(view, pixel, filter == Filter::bilateral);
}

}  // namespace scotty::reference
