/// Reads any image file, ours or not, as linear radiance.
#pragma once

#include <string>
#include <vector>

#include "verify/images/image_file.h"
#include "verify/images/measured_image.h"

namespace scotty::verify {

struct ReadImage {
    MeasuredImage image;
    ImageAttributes attributes;  ///< those whose names begin with "scotty:", numbers as text
    std::string encoding;        ///< the file's encoding: "float", "half", "uint8"
    /// Parts and layers of the file that were not read: "part 'left'", "layer 'diffuse'".
    std::vector<std::string> not_read;
};

/// Chooses a picture in a file with several; empty: the first part, and the channels without a
/// layer's name.
struct ImageChoice {
    std::string part;
    std::string layer;
};

/// Reads whatever OpenImageIO reads, NumPy's .npy of shape [height, width, 3] (which `scotty-gpu
/// run --image` and `scotty render` write), and the last image of a capture's folder. Channels are
/// found by name: R, G, B, or Y alone for grey; variance.R, variance.G, variance.B if a file has
/// them; all others, alpha too, are ignored. Integers are taken to be sRGB unless the file says
/// that they are linear. Throws bad_input naming the file: missing, not an image, cut short, other
/// channels, no such part or layer, only a part of its picture, deep.
ReadImage read_image(const std::string& path, const ImageChoice& choice = {});

/// Whether a word of the command line names an image and not a capture or a scene: its extension is
/// an image format's, or .npy.
bool is_image_path(const std::string& path);

}  // namespace scotty::verify
