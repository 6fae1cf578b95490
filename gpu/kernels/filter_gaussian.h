/// Kernel: Gaussian blur, 5 x 5, standard deviation one pixel, normalised; edges are extended.
#pragma once

#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/filter_window.h"
#include "reference/numerics/exponential.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(filter_gaussian)(FilterView view) {
    const std::uint32_t pixel = block_index() * block_size() + thread_index();
    if (pixel >= view.width * view.height) SCOTTY_RETURN;
    reference::Vec3 sum(0.0f, 0.0f, 0.0f);
    float weights = 0.0f;
    for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
            const float weight = reference::exp_minus(0.5f * static_cast<float>(dx * dx + dy * dy));
            sum += pixel_at(view, pixel, dx, dy) * weight;
            weights += weight;
        }
    }
    view.filtered[pixel] = sum / weights;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
