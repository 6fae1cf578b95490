#include "verify/mutants/made_sweep.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "reference/base/error.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

constexpr const char* kScript = "verify/mutants/made/made.py";

std::vector<std::string> words_of(const MadeSweep& sweep, const fs::path& script,
                                  const fs::path& build) {
    // Debian's Python, which has Debian's libclang.
    std::vector<std::string> words{"/usr/bin/python3", script.string(), "--build", build.string()};
    const auto add = [&](const char* option, const std::string& value) {
        if (value.empty() || value == "0") return;
        words.insert(words.end(), {option, value});
    };
    add("--files", sweep.files);
    add("--sample", std::to_string(sweep.sample));
    add("--seed", std::to_string(sweep.seed));
    add("--shard", sweep.shard);
    add("--json", sweep.json);
    add("--jobs", std::to_string(sweep.threads));
    return words;
}

}  // namespace

void become_made_sweep(const MadeSweep& sweep) {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    const fs::path build = program.parent_path().parent_path();
    for (fs::path folder = build; folder != folder.root_path(); folder = folder.parent_path()) {
        const fs::path script = folder / kScript;
        if (!fs::exists(script, ignored)) continue;
        std::vector<std::string> words = words_of(sweep, script, build);
        std::vector<char*> arguments;
        arguments.reserve(words.size() + 1);
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        ::execv(arguments[0], arguments.data());
        throw Error::missing_environment("--made: " + words[0] + " cannot be started (" +
                                         std::strerror(errno) + ")");
    }
    throw Error::missing_environment(std::string("--made: ") + kScript +
                                     " is not above the program: only a build in the project's "
                                     "folder can make faults in its sources");
}

}  // namespace scotty::verify
