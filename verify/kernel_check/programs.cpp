#include "verify/kernel_check/programs.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "reference/base/error.h"

namespace scotty::verify {

namespace {

/// In the child: becomes the other program, or ends with 127.
[[noreturn]] void become(std::vector<char*>& words, const ProgramOptions& options, int output) {
    ::dup2(output < 0 ? STDERR_FILENO : output, STDOUT_FILENO);
    if (output >= 0) ::dup2(output, STDERR_FILENO);
    if (options.seconds > 0) {
        const auto limit = static_cast<rlim_t>(options.seconds);
        const rlimit seconds{limit, limit + 1};
        ::setrlimit(RLIMIT_CPU, &seconds);
    }
    for (const std::string& variable : options.environment) {
        const std::size_t equals = variable.find('=');
        ::setenv(variable.substr(0, equals).c_str(), variable.c_str() + equals + 1, 1);
    }
    ::execvp(words[0], words.data());
    std::_Exit(127);
}

}  // namespace

ProgramRun run_program(const std::vector<std::string>& words, const ProgramOptions& options) {
    std::vector<std::string> kept = words;
    std::vector<char*> pointers;
    pointers.reserve(kept.size() + 1);
    for (std::string& word : kept) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    std::array<int, 2> ends{-1, -1};
    if (options.keep_output && ::pipe2(ends.data(), O_CLOEXEC) != 0) {
        throw reference::Error::missing_environment(std::string("no pipe: ") +
                                                    std::strerror(errno));
    }
    const pid_t child = ::fork();
    if (child == 0) become(pointers, options, ends[1]);
    if (child < 0) {
        throw reference::Error::missing_environment(words.front() +
                                                    " cannot be started: " + std::strerror(errno));
    }
    ProgramRun run;
    if (options.keep_output) {
        ::close(ends[1]);
        std::array<char, 4096> piece{};
        for (;;) {
            const ssize_t got = ::read(ends[0], piece.data(), piece.size());
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) break;
            run.output.append(piece.data(), static_cast<std::size_t>(got));
        }
        ::close(ends[0]);
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    run.out_of_time =
        WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
    return run;
}

std::string find_program(const std::string& name) {
    if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0 ? name : "";
    const char* const path = std::getenv("PATH");
    std::stringstream folders(path == nullptr ? "" : path);
    std::string folder;
    while (std::getline(folders, folder, ':')) {
        std::string file = (std::filesystem::path(folder) / name).string();
        if (::access(file.c_str(), X_OK) == 0) return file;
    }
    return "";
}

}  // namespace scotty::verify
