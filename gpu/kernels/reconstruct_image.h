/// Kernel: one thread per pixel adds up its paths' radiance and its variance, in sample order.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/stages/reconstruct_pixel.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(reconstruct_image)
(BatchView batch, std::uint32_t total_samples, const reference::Vec3* radiance,
 reference::Vec3* image, reference::Vec3* variance) {
    const std::uint32_t pixel_in_batch = block_index() * block_size() + thread_index();
    if (pixel_in_batch >= batch.pixels) SCOTTY_RETURN;
    const std::uint32_t pixel = batch.first_pixel + pixel_in_batch;
    reference::reconstruct_pixel(
        batch, total_samples, radiance + static_cast<std::size_t>(pixel_in_batch) * batch.samples,
        image[pixel], variance[pixel]);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
