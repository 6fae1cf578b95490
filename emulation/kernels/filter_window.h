/// Shared by the image filters: the image, and the pixels around a pixel.
#pragma once

#include <cstdint>

#include "emulation/kernels/views.h"
#include "reference/base/vec3.h"

namespace scotty::emulation {

/// The pixel at an offset; beyond an edge, the nearest pixel of the image.
inline reference::Vec3 pixel_at(const FilterView& view, std::uint32_t pixel, int dx, int dy) {
    const auto inside = [](int value, std::uint32_t size) {
        return value < 0 ? 0
                         : (value >= static_cast<int>(size) ? static_cast<int>(size) - 1 : value);
    };
    const int x = inside(static_cast<int>(pixel % view.width) + dx, view.width);
    const int y = inside(static_cast<int>(pixel / view.width) + dy, view.height);
    return view.image[static_cast<std::size_t>(y) * view.width + static_cast<std::size_t>(x)];
}

}  // namespace scotty::emulation
