#include "verify/images/image_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "reference/base/error.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;
constexpr const char* kFile = "scotty-images.so";

[[noreturn]] void fail(const std::string& why) {
    throw reference::Error::missing_environment(fmt::format(
        "image files other than .npy need OpenImageIO, and it cannot be loaded: {}", why));
}

/// Where the module is.
std::string find_module() {
    std::error_code ignored;
    if (const char* chosen = std::getenv("SCOTTY_IMAGE_MODULE")) {
        if (fs::is_regular_file(chosen, ignored)) return fs::absolute(chosen, ignored).string();
        fail(fmt::format("SCOTTY_IMAGE_MODULE names '{}', which is no file", chosen));
    }
    const fs::path here = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    const fs::path usual = here.parent_path() / "lib/cuda-scotty" / kFile;
    for (const fs::path& file : {usual, here / kFile}) {
        if (fs::is_regular_file(file, ignored)) return file.string();
    }
    fail(fmt::format("{} is not there", usual.string()));
}

const ImageModule& load() {
    const std::string file = find_module();
    // It stays: nobody knows which of its libraries can be unloaded.
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) fail(dlerror());
    const auto entry = reinterpret_cast<ImageModuleEntry>(dlsym(handle, kImageModuleEntry));
    if (entry == nullptr) fail(fmt::format("{} belongs to another version", file));
    return *entry();
}

}  // namespace

const ImageModule& image_module() {
    static const ImageModule& module = load();
    return module;
}

}  // namespace scotty::verify
