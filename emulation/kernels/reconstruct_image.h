/// Kernel: one thread per pixel adds up its paths' radiance, in sample order.
#pragma once

#include "emulation/kernels/views.h"

namespace scotty::emulation {

/// `image` holds running sums between batches; the batch with the last sample (`total_samples`
/// reached) turns them into means. The order of additions does not depend on the batches.
inline void reconstruct_image(std::uint32_t pixel_in_batch, const BatchView& batch,
                              std::uint32_t total_samples, const reference::Vec3* radiance,
                              reference::Vec3* image) {
    const std::uint32_t pixel = batch.first_pixel + pixel_in_batch;
    reference::Vec3 sum =
        batch.first_sample == 0 ? reference::Vec3(0.0f, 0.0f, 0.0f) : image[pixel];
    for (std::uint32_t i = 0; i < batch.samples; ++i) {
        sum += radiance[pixel_in_batch * batch.samples + i];
    }
    if (batch.first_sample + batch.samples == total_samples) {
        sum /= static_cast<float>(total_samples);
    }
    image[pixel] = sum;
}

}  // namespace scotty::emulation
