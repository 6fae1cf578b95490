/// Results as files: whole, or not at all.
#pragma once

#include <string>

namespace scotty::verify {

/// Writes a whole file, or throws bad_input naming it. Creates its folder; never leaves half a
/// file: what was there before stays until the new one is complete.
void write_file(const std::string& path, const std::string& text);

}  // namespace scotty::verify
