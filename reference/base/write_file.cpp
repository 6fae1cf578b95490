#include "reference/base/write_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "reference/base/error.h"

namespace scotty::reference {

void write_file(const std::filesystem::path& file, std::string_view bytes) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
    const fs::path unfinished = file.string() + ".unfinished";
    errno = 0;
    std::ofstream out(unfinished, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    std::string why;
    if (!out) why = errno != 0 ? std::strerror(errno) : "unknown reason";
    if (why.empty()) {
        fs::rename(unfinished, file, error);
        if (!error) return;
        why = error.message();
    }
    fs::remove(unfinished, error);
    throw Error::bad_input(file.string(), "cannot be written: " + why);
}

}  // namespace scotty::reference
