/// Kernel: median of 3 x 3, each channel for itself; edges are extended, so it is the 5th of 9.
#pragma once

#include <cstdint>

#include "emulation/kernels/filter_window.h"

namespace scotty::emulation {

/// The 5th smallest of nine values; reorders them.
inline float median_of_nine(float (&values)[9]) {
    for (int i = 0; i <= 4; ++i) {
        int least = i;
        for (int j = i + 1; j < 9; ++j) {
            if (values[j] < values[least]) least = j;
        }
        const float value = values[least];
        values[least] = values[i];
        values[i] = value;
    }
    return values[4];
}

inline void filter_median(std::uint32_t pixel, const FilterView& view) {
    float channels[3][9];
    int i = 0;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx, ++i) {
            const reference::Vec3 value = pixel_at(view, pixel, dx, dy);
            channels[0][i] = value.x;
            channels[1][i] = value.y;
            channels[2][i] = value.z;
        }
    }
    view.filtered[pixel] = reference::Vec3(median_of_nine(channels[0]), median_of_nine(channels[1]),
                                           median_of_nine(channels[2]));
}

}  // namespace scotty::emulation
