#include "verify/images/image_library.h"

#include "verify/base/loaded_module.h"

namespace scotty::verify {

const ImageModule& image_module() {
    static const ImageModule& module = *reinterpret_cast<ImageModuleEntry>(
        module_entry({"scotty-images.so", "SCOTTY_IMAGE_MODULE", kImageModuleEntry,
                      "image files other than .npy need OpenImageIO, and it"}))();
    return module;
}

}  // namespace scotty::verify
