/// What another program has to say.
#pragma once

#include <string>

namespace scotty::verify {

/// Last line that is not empty of what a shell command prints; empty where it fails.
std::string ask(const std::string& command);

}  // namespace scotty::verify
