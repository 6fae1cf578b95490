/// Asks other programs.
#pragma once

#include <string>

namespace scotty::verify {

/// Everything that a shell command prints, whatever its exit code; empty if it cannot be started.
std::string output_of(const std::string& command);

/// The last non-empty line that a shell command prints; empty if it fails.
std::string ask(const std::string& command);

/// Quotes any text as one word of a shell's command line.
std::string shell_word(const std::string& text);

}  // namespace scotty::verify
