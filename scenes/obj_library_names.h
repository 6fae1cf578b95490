/// Which file a name in an OBJ file means.
#pragma once

#include <filesystem>
#include <string_view>

namespace scotty::scenes {

/// The existing regular file that `name` stands for, relative to `folder`; empty where there is
/// none. Tried in turn: the name as it is, without quotes, with slashes for backslashes, without
/// its folders (an absolute path of somebody else's machine), and in other upper and lower case.
std::filesystem::path find_library(const std::filesystem::path& folder, std::string_view name);

}  // namespace scotty::scenes
