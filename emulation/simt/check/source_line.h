/// From an address in the program's text to the line that was compiled to it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation::simt {

/// Offset of an address in the program; 0 where it is not the program's own.
std::uint32_t offset_in_program(const void* place);

/// "gpu/intersect.h:107" for every offset, by binutils' addr2line and the program's own line
/// tables: of calls that were inlined the innermost that lies in gpu/ or a test, or else the
/// innermost. Without addr2line or line tables "scotty+0x1234". Takes a second; remembers what it
/// was asked.
std::vector<std::string> source_lines(const std::vector<std::uint32_t>& offsets);
std::string source_line(std::uint32_t offset);

}  // namespace scotty::emulation::simt
