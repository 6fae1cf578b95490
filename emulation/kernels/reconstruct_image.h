/// Kernel: one thread per pixel adds up its paths' radiance and its variance, in sample order.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/stages/reconstruct_pixel.h"

namespace scotty::emulation {

inline void reconstruct_image(std::uint32_t pixel_in_batch, const BatchView& batch,
                              std::uint32_t total_samples, const reference::Vec3* radiance,
                              reference::Vec3* image, reference::Vec3* variance) {
    const std::uint32_t pixel = batch.first_pixel + pixel_in_batch;
    reference::reconstruct_pixel(batch, total_samples,
                                 radiance + std::size_t{pixel_in_batch} * batch.samples,
                                 image[pixel], variance[pixel]);
}

}  // namespace scotty::emulation
