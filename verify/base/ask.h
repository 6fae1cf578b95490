/// What another program has to say.
#pragma once

#include <string>

namespace scotty::verify {

/// All that a shell command prints, whatever its exit code; empty where it cannot be started.
std::string output_of(const std::string& command);

/// Last line that is not empty of what a shell command prints; empty where it fails.
std::string ask(const std::string& command);

/// Any text as one word of a shell's command line.
std::string shell_word(const std::string& text);

}  // namespace scotty::verify
