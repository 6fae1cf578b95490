/// Kernel: generates all rays of this batch with as many threads as pixels. A block's threads share
/// its pixels' samples, so that neighbouring threads write neighbouring rays.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(primary_rays)
(BatchView batch, reference::Camera camera, reference::PathParameters parameters, PathView paths) {
    const std::uint32_t first = block_index() * block_size();
    const std::uint32_t left = batch.pixels - first;
    const std::uint32_t pixels = left < block_size() ? left : block_size();
    for (std::uint32_t i = thread_index(); i < pixels * batch.samples; i += block_size()) {
        const std::uint32_t ray_id = first * batch.samples + i;
        const std::uint32_t pixel = batch.first_pixel + first + i / batch.samples;
        reference::start_path(camera, parameters, pixel, batch.first_sample + i % batch.samples,
                              paths, ray_id);
    }
    SCOTTY_RETURN;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
