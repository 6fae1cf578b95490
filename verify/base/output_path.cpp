#include "verify/base/output_path.h"

#include <unistd.h>

#include <filesystem>

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

std::string why_not_in(const fs::path& folder, const std::string& what) {
    const fs::path here = folder.empty() ? fs::path(".") : folder;
    std::error_code ignored;
    if (!fs::is_directory(here, ignored)) {
        return what + ": the folder " + here.string() + " does not exist";
    }
    if (access(here.c_str(), W_OK | X_OK) != 0) {
        return what + ": the folder " + here.string() + " may not be written";
    }
    return {};
}

}  // namespace

std::string why_not_writable(const std::string& file) {
    if (file == "-") return {};
    std::error_code ignored;
    if (file.empty() || file.back() == '/' || fs::is_directory(file, ignored)) {
        return "'" + file + "' is a folder, expected the name of a file";
    }
    return why_not_in(fs::path(file).parent_path(), file);
}

CLI::Validator output_file() {
    return {[](const std::string& file) { return why_not_writable(file); }, ""};
}

CLI::Validator output_folder() {
    return {[](const std::string& folder) {
                std::error_code ignored;
                const fs::path path = fs::path(folder).lexically_normal();
                if (fs::is_directory(path, ignored)) return why_not_in(path, folder);
                if (fs::exists(path, ignored)) return folder + " is a file, expected a folder";
                const bool ends_in_slash = path.filename().empty();
                return why_not_in(
                    ends_in_slash ? path.parent_path().parent_path() : path.parent_path(), folder);
            },
            ""};
}

}  // namespace scotty::verify
