#include "verify/backends/checked_program.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "reference/base/error.h"
#include "verify/backends/simt/simt_pipeline.h"

namespace scotty::verify {

void become_program(const std::string& name, const std::string& option) {
    // As the system has them: a command line may hold anything but a zero.
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::vector<std::string> words;
    for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
    std::error_code error;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::string program = (self.parent_path() / name).string();
    if (!error && !words.empty()) {
        std::vector<char*> arguments;
        arguments.reserve(words.size() + 1);
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        ::execv(program.c_str(), arguments.data());
    }
    throw reference::Error::missing_environment(
        option + ": " + program + " cannot be started (" + std::strerror(errno) +
        "); it is built beside scotty, but not by a sanitizer preset");
}

void become_checked_program() {
    if (!simt::checks_memory()) become_program("scotty-checked", "--check");
}

}  // namespace scotty::verify
