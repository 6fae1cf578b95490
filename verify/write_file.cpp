#include "verify/write_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include "reference/error.h"

namespace scotty::verify {

void write_file(const std::string& path, const std::string& text) {
    namespace fs = std::filesystem;
    const fs::path target(path);
    std::error_code error;
    if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
    const std::string unfinished = path + ".unfinished";
    {
        std::ofstream file(unfinished, std::ios::binary);
        file << text;
        file.close();
        if (!file) {
            fs::remove(unfinished, error);
            throw reference::Error::bad_input(path, "cannot be written");
        }
    }
    fs::rename(unfinished, target, error);
    if (error) {
        const std::string why = error.message();
        fs::remove(unfinished, error);
        throw reference::Error::bad_input(path, "cannot be written: " + why);
    }
}

}  // namespace scotty::verify
