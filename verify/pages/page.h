/// Pages that open from disk: one file each, made of the files in verify/pages/web/, no network.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace scotty::verify {

/// The files of verify/pages/web/ by name, built into the program (embed.cmake).
const std::map<std::string_view, std::string_view>& page_files();

/// The page `name` with its style sheets and scripts (`<link ... href="a.css">`, `<script
/// src="b.js"></script>`, each on a line of its own) put in place, and each line `<!-- part NAME
/// -->` replaced by that part. Parts are inserted as they are, and not searched again. Throws
/// internal if a file or a part is missing.
std::string filled_page(std::string_view name, const std::map<std::string, std::string>& parts);

/// Escapes `text` as an element's content or an attribute's value.
std::string html_text(std::string_view text);

/// Writes `data` for a script element: its strings can end neither that element nor the JSON.
std::string json_for_script(const nlohmann::json& data);

}  // namespace scotty::verify
