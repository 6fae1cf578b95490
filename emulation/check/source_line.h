/// From an address in the program's text to its source line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation::simt {

/// Where the program's text begins; source_lines() takes offsets from here.
std::uintptr_t program_begin();

/// "gpu/kernels/intersect.h:107" for every offset, by binutils' addr2line and the program's own
/// line tables. For inlined calls it is the innermost line of a kernel or a test, or else the
/// innermost. Without addr2line or line tables it is "scotty+0x1234". The call takes a second, and
/// remembers its answers.
///
/// Of inlined calls, `user` takes the innermost line outside the system's headers.
enum class LineOf : std::uint8_t { kernel_text, user };
std::vector<std::string> source_lines(const std::vector<std::uint32_t>& offsets,
                                      LineOf which = LineOf::kernel_text);
std::string source_line(std::uint32_t offset, LineOf which = LineOf::kernel_text);

}  // namespace scotty::emulation::simt
