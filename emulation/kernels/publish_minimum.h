/// Kernel (early-out `level` only): what this level has lowered becomes what the next one reads.
#pragma once

#include <cstdint>

namespace scotty::emulation {

inline void publish_minimum(std::uint32_t ray_id, const float* lowered, float* minimum) {
    minimum[ray_id] = lowered[ray_id];
}

}  // namespace scotty::emulation
