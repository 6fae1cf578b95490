/// The one exception type of the suite: what went wrong, where, and the way out.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace scotty::reference {

/// Who has to act, which is also what the exit code says.
enum class ErrorKind {
    bad_input,            ///< usage, a file or a parameter is wrong: exit code 2
    missing_environment,  ///< a device or library that was required is not there: exit code 3
    internal              ///< a contract of the suite itself is broken: exit code 70
};

/// Thrown at boundaries: I/O, command line, Embree and CUDA calls, contracts.
/// The message names file and element (or parameter), what was expected and what was found.
class Error : public std::runtime_error {
 public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

    /// `where` is a file, element or parameter: "scene.obj: triangle 17".
    static Error bad_input(const std::string& where, const std::string& what) {
        return {ErrorKind::bad_input, where + ": " + what};
    }
    static Error missing_environment(const std::string& what) {
        return {ErrorKind::missing_environment, what};
    }
    static Error internal(const std::string& what) { return {ErrorKind::internal, what}; }

    ErrorKind kind() const { return kind_; }

 private:
    ErrorKind kind_;
};

}  // namespace scotty::reference
