/// Kernel: one thread per pixel generates all its rays of this batch.
#pragma once

#include "gpu/dialect.h"
#include "gpu/views.h"
#include "reference/path.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(primary_rays)
(BatchView batch, reference::Camera camera, reference::PathParameters parameters, PathView paths) {
    const std::uint32_t pixel_in_batch = block_index() * block_size() + thread_index();
    if (pixel_in_batch >= batch.pixels) SCOTTY_RETURN;
    const std::uint32_t pixel = batch.first_pixel + pixel_in_batch;
    for (std::uint32_t i = 0; i < batch.samples; ++i) {
        const std::uint32_t ray_id = pixel_in_batch * batch.samples + i;
        const std::uint32_t sample = batch.first_sample + i;
        paths.rays[ray_id] = reference::primary_ray(camera, parameters, pixel, sample);
        paths.throughput[ray_id] = reference::Vec3(1.0f, 1.0f, 1.0f);
        paths.radiance[ray_id] = reference::Vec3(0.0f, 0.0f, 0.0f);
        paths.potential[ray_id] = reference::Vec3(0.0f, 0.0f, 0.0f);
        paths.pixel[ray_id] = pixel;
        paths.sample[ray_id] = sample;
        paths.depth[ray_id] = 0;
        paths.flags[ray_id] = reference::kPathAlive;
    }
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
