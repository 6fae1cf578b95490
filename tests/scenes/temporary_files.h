/// Small files for the loaders, in a folder that goes away with the test.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "scenes/scenes.h"

namespace scotty::tests {

class TemporaryFiles {
 public:
    TemporaryFiles() {
        folder_ = std::filesystem::temp_directory_path() /
                  ("scotty_test_" + std::to_string(::getpid()) + "_" + std::to_string(++count_));
        std::filesystem::create_directories(folder_);
    }
    ~TemporaryFiles() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    TemporaryFiles(const TemporaryFiles&) = delete;
    TemporaryFiles& operator=(const TemporaryFiles&) = delete;

    /// Writes a file and returns its path.
    std::string write(const std::string& name, const std::string& content) const {
        const std::string path = (folder_ / name).string();
        std::ofstream(path, std::ios::binary) << content;
        return path;
    }
    reference::Scene load(const std::string& name, const std::string& content,
                          const std::string& suffix = "") const {
        return scenes::load_scene(write(name, content) + suffix);
    }

 private:
    static inline int count_ = 0;
    std::filesystem::path folder_;
};

/// `text` with the first `from` replaced by `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::logic_error("test text lacks: " + from);
    return text.replace(at, from.size(), to);
}

}  // namespace scotty::tests
