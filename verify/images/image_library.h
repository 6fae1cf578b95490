/// Loads the module that reads and writes image files, when it is first needed.
#pragma once

#include "verify/image_module/image_module.h"

namespace scotty::verify {

/// The module lies in ../lib/cuda-scotty/ from the program, where the build and an installation put
/// it, or beside the program; the environment variable SCOTTY_IMAGE_MODULE names another file.
/// Throws missing_environment that says which file or library is missing; what needs no image file
/// never asks. `.npy` files need no module.
const ImageModule& image_module();

}  // namespace scotty::verify
