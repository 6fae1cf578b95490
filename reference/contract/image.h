/// A linear-radiance RGB image in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/base/vec3.h"

namespace scotty::reference {

/// Row-major from the top left; pixel (x, y) is pixels[y * width + x].
struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<Vec3> pixels;
    /// Estimated variance of each pixel's mean, by channel; empty where it is not known.
    std::vector<Vec3> variance = {};
};

}  // namespace scotty::reference
