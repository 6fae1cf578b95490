/// Libraries that only some commands need: modules, loaded when they are first asked for.
#pragma once

#include <string>

namespace scotty::verify {

struct ModuleName {
    const char* file;      ///< "scotty-images.so"
    const char* variable;  ///< of the environment: the path of another file
    const char* entry;     ///< the module's one function
    const char* what;      ///< "image files other than .npy need OpenImageIO, and it"
};

/// The address of the module's function. The module lies in ../lib/cuda-scotty/ from the program,
/// where the build and an installation put it, or beside the program. It stays loaded. Throws
/// missing_environment that begins with `what` and says which file or library is missing.
void* module_entry(const ModuleName& name);

}  // namespace scotty::verify
