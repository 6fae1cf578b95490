/// Shared by the image filters: the image, and the pixels around a pixel.
#pragma once

#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/base/vec3.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// The nearest valid coordinate.
SCOTTY_DEVICE int inside(int value, std::uint32_t size) {
    return value < 0 ? 0 : (value >= static_cast<int>(size) ? static_cast<int>(size) - 1 : value);
}

/// The pixel at an offset; beyond an edge, the nearest pixel of the image.
SCOTTY_DEVICE reference::Vec3 pixel_at(const FilterView& view, std::uint32_t pixel, int dx,
                                       int dy) {
    const int x = inside(static_cast<int>(pixel % view.width) + dx, view.width);
    const int y = inside(static_cast<int>(pixel / view.width) + dy, view.height);
    return view.image[static_cast<std::size_t>(y) * view.width + static_cast<std::size_t>(x)];
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
