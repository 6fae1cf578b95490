/// Starts other programs and waits for them.
#pragma once

#include <string>
#include <vector>

namespace scotty::verify {

struct ProgramRun {
    int exit_code = 0;  ///< 128 and more: ended by that signal
    bool out_of_time = false;
    std::string output;  ///< standard output and standard error, where they were asked for
};

struct ProgramOptions {
    bool keep_output = false;              ///< otherwise both go to this program's standard error
    int seconds = 0;                       ///< of processor time; 0: no limit
    std::vector<std::string> environment;  ///< NAME=VALUE, beside this program's own
};

/// Runs words.front() with the others as arguments; it is found in $PATH. Throws
/// missing_environment where it cannot be started.
ProgramRun run_program(const std::vector<std::string>& words, const ProgramOptions& options = {});
/// The path of a program in $PATH; empty where there is none.
std::string find_program(const std::string& name);

}  // namespace scotty::verify
