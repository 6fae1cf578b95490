#include <stdexcept>

#include "reference/base/error.h"
#include "tests/fuzz/readers.h"

namespace scotty::tests {

namespace fs = std::filesystem;

bool try_reader(const Reader& reader, const fs::path& folder, std::string_view bytes) {
    try {
        reader.read(folder, bytes);
        return true;
    } catch (const reference::Error& error) {
        if (error.kind() == reference::ErrorKind::bad_input) return false;
        throw std::logic_error(std::string(reader.name) +
                               ": refused, but not as bad input: " + error.what());
    } catch (const std::exception& error) {
        throw std::logic_error(std::string(reader.name) +
                               ": not refused, but thrown: " + error.what());
    }
}

}  // namespace scotty::tests
