/// Kernel: (early-out `level` only) publishes this level's lowered minima to the next level.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(publish_minimum)(std::uint32_t count, const float* lowered, float* minimum) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    minimum[ray_id] = lowered[ray_id];
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
