/// exp(-x) for kernels: exact arithmetic only, the same bits on CPU and GPU.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "reference/base/host_device.h"

namespace scotty::reference {

/// exp(-x) for x >= 0, relative error below 5e-7; 0 from x = 87 on (before results get subnormal).
SCOTTY_HD float exp_minus(float x) {
    if (!(x < 87.0f)) return 0.0f;
    // To the nearest power of two, and what is left from x itself: of y it would keep the rounding.
    const float power = x * 1.44269504f + 0.5f;
    const auto whole = static_cast<std::int32_t>(power);
    const float r = fmaf(static_cast<float>(whole), -0.69314718f, x);  // -ln(2)/2 .. ln(2)/2
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
