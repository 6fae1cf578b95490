/// An image with its noise as an OpenEXR file: float32, lossless, channels R G B and
/// variance.R variance.G variance.B, which other programs show as a layer.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "verify/measured_image.h"

namespace scotty::verify {

/// What a file says of where it comes from, by name.
using Provenance = std::map<std::string, std::string>;

/// The same image and provenance give the same bytes. Written beside the target and renamed; the
/// folder must exist. Throws bad_input naming the file.
void write_golden_image(const MeasuredImage& image, const Provenance& provenance,
                        const std::filesystem::path& file);

struct GoldenImageFile {
    MeasuredImage image;    ///< variance is empty where the file has no such channels
    Provenance provenance;  ///< what write_golden_image() was given
};

/// Channels by name, whatever their order. Throws bad_input naming file and channel.
GoldenImageFile read_golden_image(const std::filesystem::path& file);

}  // namespace scotty::verify
