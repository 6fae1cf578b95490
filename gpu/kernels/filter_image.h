/// Kernel: one thread per pixel filters the image.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/stages/filters.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(filter_image)(FilterView view, reference::Filter filter) {
    const std::uint32_t pixel = block_index() * block_size() + thread_index();
    if (pixel >= view.width * view.height) SCOTTY_RETURN;
    reference::filter_pixel(view, filter, pixel);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
