/// Small files for the loaders, in a folder that goes away with the test.
#pragma once

#include <stdexcept>
#include <string>

#include "scenes/scenes.h"
#include "tests/temporary_folder.h"

namespace scotty::tests {

class TemporaryFiles {
 public:
    /// Writes a file and returns its path.
    std::string write(const std::string& name, const std::string& content) const {
        const std::string path = folder_.file(name.c_str());
        spill(path, content);
        return path;
    }
    reference::Scene load(const std::string& name, const std::string& content,
                          const std::string& suffix = "") const {
        return scenes::load_scene(write(name, content) + suffix);
    }

 private:
    TemporaryFolder folder_;
};

/// `text` with the first `from` replaced by `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::logic_error("test text lacks: " + from);
    return text.replace(at, from.size(), to);
}

}  // namespace scotty::tests
