/// Kernel: bilateral filter, 5 x 5 (Tomasi and Manduchi 1998): near pixels of similar radiance.
#pragma once

#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/filter_window.h"
#include "reference/numerics/exponential.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Standard deviations: one pixel in space; in radiance this share of the centre pixel's largest
/// channel plus a floor, so that exposure does not change what counts as an edge.
constexpr float kBilateralRange = 0.25f;
constexpr float kBilateralFloor = 0.02f;

SCOTTY_KERNEL(filter_bilateral)(FilterView view) {
    const std::uint32_t pixel = block_index() * block_size() + thread_index();
    if (pixel >= view.width * view.height) SCOTTY_RETURN;
    const reference::Vec3 centre = view.image[pixel];
    const float sigma = kBilateralRange * reference::max_abs(centre) + kBilateralFloor;
    reference::Vec3 sum(0.0f, 0.0f, 0.0f);
    float weights = 0.0f;
    for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
            const reference::Vec3 value = pixel_at(view, pixel, dx, dy);
            const reference::Vec3 difference = value - centre;
            const float range = reference::dot(difference, difference) / (sigma * sigma);
            const float weight =
                reference::exp_minus(0.5f * (static_cast<float>(dx * dx + dy * dy) + range));
            sum += value * weight;
            weights += weight;
        }
    }
    view.filtered[pixel] = sum / weights;  // the centre weighs 1, so this is never 0 / 0
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
