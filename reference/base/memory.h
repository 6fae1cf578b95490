/// Whether there is memory for what is about to be done: asked before, not found out by dying.
#pragma once

#include <cstdint>
#include <string>

namespace scotty::reference {

/// Bytes that this process may still take: the least of what the system has free, what its control
/// group leaves and what `ulimit -v` leaves (proc(5), getrlimit(2)).
std::uint64_t available_memory();

/// Throws missing_environment saying how much `what` needs, how much there is, and `way_out`.
void require_memory(std::uint64_t bytes, const std::string& what, const std::string& way_out);

/// From now on memory of up to 32 MiB a piece that is freed stays with the process, to be taken
/// again: the pages of a picture are touched for the first time once, not in every render.
void keep_freed_memory();

}  // namespace scotty::reference
