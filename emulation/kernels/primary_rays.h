/// Kernel: one thread per pixel generates all its rays of this batch.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace scotty::emulation {

inline void primary_rays(std::uint32_t pixel_in_batch, const BatchView& batch,
                         const reference::Camera& camera,
                         const reference::PathParameters& parameters, const PathView& paths) {
    for (std::uint32_t i = 0; i < batch.samples; ++i) {
        reference::start_path(camera, parameters, batch.first_pixel + pixel_in_batch,
                              batch.first_sample + i, paths, pixel_in_batch * batch.samples + i);
    }
}

}  // namespace scotty::emulation
