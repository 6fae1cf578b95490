#include "verify/mutants/processes.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>

#include "reference/base/error.h"
#include "verify/base/exit_code.h"

namespace scotty::verify {

namespace {

using Clock = std::chrono::steady_clock;
using File = std::unique_ptr<FILE, int (*)(FILE*)>;

struct Running {
    std::size_t index;
    Clock::time_point started;
    File output, errors;
};

[[noreturn]] void fail(const char* what) {
    throw reference::Error::missing_environment(std::string(what) + ": " + std::strerror(errno));
}

File scratch_file() {
    File file(std::tmpfile(), std::fclose);
    if (file == nullptr) fail("a temporary file");
    return file;
}

/// Runs in the new process; does not return.
[[noreturn]] void run_here(const CommandRunner& run_command, const std::vector<std::string>& words,
                           const Running& running, unsigned seconds) {
    ::dup2(::fileno(running.output.get()), STDOUT_FILENO);
    ::dup2(::fileno(running.errors.get()), STDERR_FILENO);
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::alarm(seconds);
    std::vector<std::string> copy{"scotty"};
    copy.insert(copy.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    arguments.reserve(copy.size());
    for (std::string& word : copy) arguments.push_back(word.data());
    const int code = run_command(static_cast<int>(arguments.size()), arguments.data());
    std::cout.flush();
    std::fflush(nullptr);
    ::_exit(code);  // the statics are the parent process's
}

std::string text_of(FILE* file) {
    std::string text;
    std::rewind(file);
    char piece[4096];
    while (const std::size_t got = std::fread(piece, 1, sizeof piece, file))
        text.append(piece, got);
    return text;
}

ProcessOutcome outcome_of(const Running& running, int status) {
    ProcessOutcome outcome;
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    outcome.timed_out = outcome.signal == SIGALRM;
    outcome.output = text_of(running.output.get());
    outcome.errors = text_of(running.errors.get());
    outcome.seconds = std::chrono::duration<double>(Clock::now() - running.started).count();
    return outcome;
}

}  // namespace

void run_in_processes(
    const CommandRunner& run_command, const std::vector<std::vector<std::string>>& commands,
    const ProcessLimits& limits,
    const std::function<void(std::size_t index, const ProcessOutcome& outcome)>& done) {
    std::map<pid_t, Running> all;
    std::size_t next = 0;
    while (next < commands.size() || !all.empty()) {
        while (next < commands.size() && all.size() < limits.at_once) {
            Running running{next, Clock::now(), scratch_file(), scratch_file()};
            std::cout.flush();
            std::fflush(nullptr);
            const pid_t process = ::fork();
            if (process < 0) fail("starting a process");
            if (process == 0) run_here(run_command, commands[next], running, limits.seconds);
            all.emplace(process, std::move(running));
            ++next;
        }
        int status = 0;
        const pid_t ended = ::wait(&status);
        if (ended < 0 && errno != EINTR) fail("waiting for a process");
        const auto found = all.find(ended);
        if (found == all.end()) continue;
        const ProcessOutcome outcome = outcome_of(found->second, status);
        const std::size_t index = found->second.index;
        all.erase(found);
        done(index, outcome);
    }
}

}  // namespace scotty::verify
