/// The command as a user runs it: exit code and both streams.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/commands/command.h"

namespace scotty::verify::test {

struct Result {
    int exit_code = -1;
    std::string out, err;
};

inline Result run(const std::filesystem::path& program, const std::string& arguments) {
    const TemporaryFolder folder;
    REQUIRE(std::filesystem::exists(program));
    const std::string command = "'" + program.string() + "' " + arguments + " >'" +
                                folder.file("out") + "' 2>'" + folder.file("err") + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(folder.file("out")),
            slurp(folder.file("err"))};
}

/// `scotty` lies beside this test program.
inline Result run_scotty(const std::string& arguments) {
    return run(std::filesystem::read_symlink("/proc/self/exe").parent_path() / "scotty", arguments);
}

/// A stream of this process into a file, for as long as this lives.
class Redirected {
 public:
    Redirected(FILE* stream, const std::string& path) : stream_(stream) {
        std::fflush(stream_);
        saved_ = dup(fileno(stream_));
        const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(file, fileno(stream_));
        close(file);
    }
    Redirected(const Redirected&) = delete;
    Redirected& operator=(const Redirected&) = delete;
    ~Redirected() {
        std::fflush(stream_);
        dup2(saved_, fileno(stream_));
        close(saved_);
    }

 private:
    FILE* stream_;
    int saved_ = -1;
};

/// The same in this process. Words are split at blanks, quotes are taken off.
inline Result scotty_here(const std::string& arguments) {
    std::vector<std::string> words{"scotty"};
    std::istringstream split(arguments);
    for (std::string word; split >> word;) {
        std::erase(word, '\'');
        words.push_back(word);
    }
    std::vector<char*> argv;
    argv.reserve(words.size());
    for (std::string& word : words) argv.push_back(word.data());
    const TemporaryFolder folder;
    Result result;
    {
        const Redirected out(stdout, folder.file("out"));
        const Redirected err(stderr, folder.file("err"));
        result.exit_code = scotty::verify::run_command(static_cast<int>(argv.size()), argv.data());
    }
    result.out = slurp(folder.file("out"));
    result.err = slurp(folder.file("err"));
    return result;
}

}  // namespace scotty::verify::test
