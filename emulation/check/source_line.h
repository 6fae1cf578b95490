/// From an address in the program's text to the line that was compiled to it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation::simt {

/// Where the program's text lies: what source_lines() is asked for are offsets from here.
std::uintptr_t program_begin();

/// "gpu/kernels/intersect.h:107" for every offset, by binutils' addr2line and the program's own
/// line tables: of calls that were inlined the innermost that is a kernel's or a test's, or else
/// the innermost. Without addr2line or line tables "scotty+0x1234". Takes a second; remembers what
/// it was asked.
std::vector<std::string> source_lines(const std::vector<std::uint32_t>& offsets);
std::string source_line(std::uint32_t offset);

}  // namespace scotty::emulation::simt
