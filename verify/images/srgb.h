/// The transfer curve of sRGB, both ways (IEC 61966-2-1).
#pragma once

#include <cmath>

namespace scotty::verify {

/// Linear 0 to 1 to encoded 0 to 1, clamped.
inline float srgb_encode(float linear) {
    if (!(linear > 0.0f)) return 0.0f;  // NaN too: the verification finds those
    if (linear >= 1.0f) return 1.0f;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

inline double srgb_decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace scotty::verify
