/// Runs commands of this program in processes of their own, so that crashes and hangs harm none.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace scotty::verify {

struct ProcessOutcome {
    int exit_code = 0;  ///< -1 if it did not get that far
    int signal = 0;     ///< the signal that ended it; 0: none
    bool timed_out = false;
    std::string output;  ///< of standard output
    std::string errors;  ///< of standard error
    double seconds = 0.0;
};

struct ProcessLimits {
    std::size_t at_once = 1;  ///< processes
    unsigned seconds = 120;   ///< after which a process is ended
};

/// Runs a whole command line in this process; returns its exit code.
using CommandRunner = std::function<int(int argc, char** argv)>;

/// Hands each command line ("verify", "coil", ...; without the program's name) to `run_command` in
/// a fork of this process, which must not have started threads until then. `done` is called in the
/// order in which they end. Throws missing_environment if a process cannot be started.
void run_in_processes(
    const CommandRunner& run_command, const std::vector<std::vector<std::string>>& commands,
    const ProcessLimits& limits,
    const std::function<void(std::size_t index, const ProcessOutcome& outcome)>& done);

}  // namespace scotty::verify
