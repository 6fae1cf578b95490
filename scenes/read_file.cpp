#include <fstream>
#include <iterator>

#include "reference/base/error.h"
#include "scenes/file_checks.h"

namespace scotty::scenes {

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file) throw reference::Error::bad_input(path, "cannot be read");
    return bytes;
}

}  // namespace scotty::scenes
