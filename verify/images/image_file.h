/// Images to files.
#pragma once

#include <map>
#include <string>

#include "reference/contract/image.h"
#include "verify/images/measured_image.h"

namespace scotty::verify {

/// Writes .exr (linear radiance, float32, lossless), .png (8-bit sRGB of radiance * 2^exposure,
/// clamped at 1) or .npy (picture_arrays.h). It writes beside the target and renames, so that no
/// reader ever sees half a picture. Throws bad_input naming the file: unknown extension, folder
/// missing, not writable; missing_environment where the library for image files is (.npy needs
/// none).
void write_image(const reference::Image& image, const std::string& path, float exposure = 0.0f);

/// Names and values kept in a file's header, such as "scotty:scene" and "coil".
using ImageAttributes = std::map<std::string, std::string>;

/// Writes an .exr with channels R, G, B and, if variances are known, variance.R, variance.G,
/// variance.B: float32, lossless, and the same bytes for the same image and attributes.
/// `scotty:samples` and, unless it is 1, `scotty:paths_per_sample` are attributes that it adds.
/// A .npy has the same in the files beside it. verify/images/image_read.h reads both back. Throws
/// as write_image does.
void write_measured_image(const MeasuredImage& image, const std::string& path,
                          const ImageAttributes& attributes = {});

/// Checks the name as write_image does, before hours of rendering, and loads the library.
void check_image_path(const std::string& path);

}  // namespace scotty::verify
