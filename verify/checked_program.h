/// --check: the same command, run by the program whose kernels report every load and store.
#pragma once

namespace scotty::verify {

/// Replaces this process by scotty-checked, beside it, with the same arguments; returns only in
/// scotty-checked itself. Throws missing_environment where there is none.
void become_checked_program();

}  // namespace scotty::verify
