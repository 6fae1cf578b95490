#include "scenes/obj_library_names.h"

#include <algorithm>
#include <string>

#include "scenes/obj_lines.h"

namespace scotty::scenes {

namespace fs = std::filesystem;

namespace {

bool is_file(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

std::string lower_case(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

/// The first in the alphabet, because the order of a folder's entries is not defined.
fs::path file_in_other_case(const fs::path& wanted) {
    const fs::path folder = wanted.has_parent_path() ? wanted.parent_path() : fs::path(".");
    const std::string name = lower_case(wanted.filename().string());
    std::error_code failed;
    fs::path found;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        if (lower_case(entry->path().filename().string()) != name) continue;
        if (is_file(entry->path()) && (found.empty() || entry->path() < found)) {
            found = entry->path();
        }
    }
    return found;
}

}  // namespace

fs::path find_library(const fs::path& folder, std::string_view name) {
    // A name with a zero byte in it is none that a file can have.
    if (name.empty() || name.find('\0') != std::string_view::npos) return {};
    if (is_file(folder / name)) return folder / name;
    if (name.size() > 2 && name.front() == '"' && name.back() == '"') {
        name = trimmed(name.substr(1, name.size() - 2));
    }
    std::string slashes(name);
    std::replace(slashes.begin(), slashes.end(), '\\', '/');
    for (const fs::path& path :
         {folder / name, folder / slashes, folder / fs::path(slashes).filename()}) {
        if (is_file(path)) return path;
    }
    for (const fs::path& path : {folder / slashes, folder / fs::path(slashes).filename()}) {
        fs::path found = file_in_other_case(path);
        if (!found.empty()) return found;
    }
    return {};
}

}  // namespace scotty::scenes
