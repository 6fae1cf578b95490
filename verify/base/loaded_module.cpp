#include "verify/base/loaded_module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "reference/base/error.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const ModuleName& name, const std::string& why) {
    throw reference::Error::missing_environment(
        fmt::format("{} cannot be loaded: {}", name.what, why));
}

std::string find_module(const ModuleName& name) {
    std::error_code ignored;
    if (const char* chosen = std::getenv(name.variable)) {
        if (fs::is_regular_file(chosen, ignored)) return fs::absolute(chosen, ignored).string();
        refuse(name, fmt::format("{} names '{}', which is no file", name.variable, chosen));
    }
    const fs::path here = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    const fs::path usual = here.parent_path() / "lib/cuda-scotty" / name.file;
    for (const fs::path& file : {usual, here / name.file}) {
        if (fs::is_regular_file(file, ignored)) return file.string();
    }
    refuse(name, fmt::format("{} is not there", usual.string()));
}

}  // namespace

void* module_entry(const ModuleName& name) {
    const std::string file = find_module(name);
    // It stays: nobody knows which of its libraries can be unloaded.
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) refuse(name, dlerror());
    void* entry = dlsym(handle, name.entry);
    if (entry == nullptr) refuse(name, fmt::format("{} belongs to another version", file));
    return entry;
}

}  // namespace scotty::verify
