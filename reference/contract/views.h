/// What the kernels of every back end are handed alike: plain pointers into its buffers, and sizes.
#pragma once

#include <cstdint>

#include "reference/contract/records.h"

namespace scotty::reference {

/// State of every path in flight, by ray id.
struct PathView {
    Ray* rays;
    Vec3* throughput;
    Vec3* radiance;
    Vec3* potential;
    std::uint32_t* pixel;
    std::uint32_t* sample;
    std::uint32_t* depth;
    std::uint32_t* flags;
};

/// Pixels [first_pixel, first_pixel + pixels) and, of each, samples [first_sample, first_sample +
/// samples). The paths of a pixel are neighbours: ray id = pixel in the batch * samples + i.
struct BatchView {
    std::uint32_t first_pixel;
    std::uint32_t pixels;
    std::uint32_t first_sample;
    std::uint32_t samples;
};

/// An image and where its filtered copy goes.
struct FilterView {
    std::uint32_t width;
    std::uint32_t height;
    const Vec3* image;
    Vec3* filtered;
};

}  // namespace scotty::reference
