/// --check, --plant and --backend cuda: the same command, run by a program beside this one that can
/// do it.
#pragma once

#include <string>

namespace scotty::verify {

/// Replaces this process by a program of the same folder, with the same arguments. Throws
/// missing_environment, naming the option that asked for it, where there is none.
void become_program(const std::string& name, const std::string& option);

/// Goes on as scotty-checked, whose kernels report every load and store; returns only where this
/// program's do already.
void become_checked_program();

}  // namespace scotty::verify
