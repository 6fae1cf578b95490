/// Kernel: one thread per pixel filters the image.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/stages/filters.h"

namespace scotty::emulation {

inline void filter_image(std::uint32_t pixel, reference::Filter filter, const FilterView& view) {
    reference::filter_pixel(view, filter, pixel);
}

}  // namespace scotty::emulation
