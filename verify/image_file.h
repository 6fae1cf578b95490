/// Images to files.
#pragma once

#include <string>

#include "reference/image.h"

namespace scotty::verify {

/// Writes .exr (linear radiance, float32, lossless) or .png (8-bit sRGB of radiance * 2^exposure,
/// clamped at 1). Written beside the target and renamed when whole, so that no reader ever sees
/// half a picture. Throws bad_input naming the file: unknown extension, folder missing, not
/// writable.
void write_image(const reference::Image& image, const std::string& path, float exposure = 0.0f);

/// The same check of the name that write_image makes, before hours of rendering.
void check_image_path(const std::string& path);

}  // namespace scotty::verify
