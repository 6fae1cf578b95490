/// Kernel (early-out `level` only): publishes this level's lowered minima to the next level.
#pragma once

#include <cstdint>

namespace scotty::emulation {

inline void publish_minimum(std::uint32_t ray_id, const float* lowered, float* minimum) {
    minimum[ray_id] = lowered[ray_id];
}

}  // namespace scotty::emulation
