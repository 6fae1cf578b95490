/// exp(-x) for kernels: exact arithmetic only, the same bits on CPU and GPU.
#pragma once

#include <cstdint>
#include <cstring>

#include "reference/host_device.h"

namespace scotty::reference {

/// exp(-x) for x >= 0, relative error below 2e-6; 0 from x = 87 on (before results get subnormal).
SCOTTY_HD float exp_minus(float x) {
    if (!(x < 87.0f)) return 0.0f;
    const float y = x * 1.44269504f;  // in powers of two
    const std::int32_t whole = static_cast<std::int32_t>(y);
    const float r = (y - static_cast<float>(whole)) * 0.69314718f;  // 0 .. ln 2
    const float fraction =
        1.0f + r * (-1.0f + r * (0.5f + r * (-1.6666667e-1f +
                                             r * (4.1666667e-2f +
                                                  r * (-8.3333333e-3f +
                                                       r * (1.3888889e-3f + r * -1.984127e-4f))))));
    const std::uint32_t bits = static_cast<std::uint32_t>(127 - whole) << 23;
    float scale = 0.0f;
    memcpy(&scale, &bits, sizeof(scale));
    return fraction * scale;
}

}  // namespace scotty::reference
