#include "reference/error.h"
#include "scenes/loaders.h"

namespace scotty::scenes {

reference::Scene load_collada(const std::string& path, CameraChoice) {
    throw reference::Error::bad_input(path, "COLLADA is not read yet");
}

}  // namespace scotty::scenes
