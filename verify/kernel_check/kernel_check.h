/// Checks a CUDA program: translates and compiles it with the host's compiler, runs it on the
/// executor of emulation/cuda/ under some schedules, and says what it found.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace scotty::verify {

struct KernelCheck {
    std::vector<std::string> sources;
    std::vector<std::string> include_folders;
    std::vector<std::string> definitions;  ///< NAME or NAME=VALUE
    std::string standard = "c++17";
    std::string compiler;  ///< empty: $CXX, or the first of g++, c++
    std::string launch;    ///< "k<<<1, 32>>>(float[32], 7)"; empty: the program has a main()
    std::vector<std::string> arguments;
    std::vector<std::string> schedules = {"linear"};
    bool strict = false;  ///< early returns before a barrier are findings, warnings fail
    int seconds = 60;     ///< of processor time, for each run
};

/// What one program did.
struct KernelReport {
    std::string name;         ///< the first source
    nlohmann::json findings;  ///< array; each with "schedules", in which it was seen
    std::vector<std::string> schedules;
    double seconds = 0.0;
    int exit_code = 0;  ///< of the program itself, in the first run that failed
    bool ended_by_itself = true;
    bool failed = false;
    std::string text;  ///< the findings for people
};

/// Throws bad_input for text that is not supported or does not compile, missing_environment where
/// there is no compiler.
KernelReport check_kernels(const KernelCheck& check);

nlohmann::json to_json(const KernelReport& report);
/// A suite with a case for the program; each finding is a failure.
std::string to_junit(const KernelReport& report);

/// The text of a main() that carries out `launch`: arrays get memory with small numbers in it.
/// Throws bad_input.
std::string main_of_launch(const std::string& launch);

}  // namespace scotty::verify
