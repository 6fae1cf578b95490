/// Kernel: one thread per pixel generates all its rays of this batch.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/numerics/path.h"

namespace scotty::emulation {

inline void primary_rays(std::uint32_t pixel_in_batch, const BatchView& batch,
                         const reference::Camera& camera,
                         const reference::PathParameters& parameters, const PathView& paths) {
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

}  // namespace scotty::emulation
