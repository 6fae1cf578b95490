/// Two pictures of one view, side by side: where they differ, outlined.
#pragma once

#include <cstdint>
#include <string>

#include "reference/contract/image.h"
#include "verify/view/display.h"

namespace scotty::verify {

struct PictureComparison {
    std::uint64_t pixels = 0, different = 0;  ///< different: not the same bits
    std::uint32_t first_x = 0, first_y = 0;   ///< the first that differs
    double largest = 0.0;                     ///< difference of a channel, in radiance
    /// |a - b|, eight times as bright as the pictures, with outlines.
    ColorImage a, b, difference;
};

/// Both are as large as each other. What lies beside a pixel that differs is drawn red in all three
/// pictures, so that one pixel is not overlooked.
PictureComparison compare_pictures(const reference::Image& a, const reference::Image& b,
                                   float exposure, ToneMap tone);

/// float32 [height, width, 3] of an .npy file. Throws bad_input naming it where it is none.
reference::Image read_radiance(const std::string& file);

}  // namespace scotty::verify
