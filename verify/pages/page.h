/// Pages that open from disk: one file each, made of the files in verify/pages/web/, no network.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace scotty::verify {

/// The files of verify/pages/web/ by name, built into the program (page/embed.cmake).
const std::map<std::string_view, std::string_view>& page_files();

/// The page `name` with its style sheets and scripts (`<link ... href="a.css">`,
/// `<script src="b.js"></script>`, each on a line of its own) put in place, and each line
/// `<!-- part NAME -->` replaced by that part. Parts are put in as they are, and not looked
/// through again. Throws internal where a file or a part is missing.
std::string filled_page(std::string_view name, const std::map<std::string, std::string>& parts);

/// `text` as an element's content or an attribute's value.
std::string html_text(std::string_view text);

/// `data` for a script element: it cannot end that element, nor the JSON, whatever its strings
/// hold.
std::string json_for_script(const nlohmann::json& data);

}  // namespace scotty::verify
