/// Results as files: whole, or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace scotty::reference {

/// Writes a whole file, or throws bad_input naming it and the system's reason (no room, not
/// allowed). Creates its folder. What was there before stays until the new file is complete: it is
/// written beside it as FILE.unfinished and renamed.
void write_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace scotty::reference
