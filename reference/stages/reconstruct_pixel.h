/// Stage reconstruct_image for one pixel.
#pragma once

#include <cstdint>

#include "reference/base/host_device.h"
#include "reference/contract/views.h"
#include "reference/numerics/pixel_sums.h"

namespace scotty::reference {

/// Adds the batch's samples of one pixel, `radiance[batch.samples]`, in their order. `image` and
/// `variance` hold running sums between batches (PixelSums); the batch with the last of
/// `total_samples` finishes them. The order of additions does not depend on the batches.
SCOTTY_STAGE void reconstruct_pixel(const BatchView& batch, std::uint32_t total_samples,
                                    const Vec3* radiance, Vec3& image, Vec3& variance) {
    PixelSums sums;
    if (batch.first_sample != 0) sums = {image, variance};
    for (std::uint32_t i = 0; i < batch.samples; ++i) {
        add_sample(sums, batch.first_sample + i, radiance[i]);
    }
    if (batch.first_sample + batch.samples == total_samples) finish(sums, total_samples);
    image = sums.image;
    variance = sums.variance;
}

}  // namespace scotty::reference
