/// Kernel: one thread per pixel adds up its paths' radiance and its variance, in sample order.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/numerics/pixel_sums.h"

namespace scotty::emulation {

/// `image` and `variance` hold running sums between batches (PixelSums); the batch with the last
/// sample (`total_samples` reached) finishes them. The order of additions does not depend on the
/// batches.
inline void reconstruct_image(std::uint32_t pixel_in_batch, const BatchView& batch,
                              std::uint32_t total_samples, const reference::Vec3* radiance,
                              reference::Vec3* image, reference::Vec3* variance) {
    const std::uint32_t pixel = batch.first_pixel + pixel_in_batch;
    reference::PixelSums sums;
    if (batch.first_sample != 0) sums = {image[pixel], variance[pixel]};
    for (std::uint32_t i = 0; i < batch.samples; ++i) {
        reference::add_sample(sums, batch.first_sample + i,
                              radiance[pixel_in_batch * batch.samples + i]);
    }
    if (batch.first_sample + batch.samples == total_samples) {
        reference::finish(sums, total_samples);
    }
    image[pixel] = sums.image;
    variance[pixel] = sums.variance;
}

}  // namespace scotty::emulation
