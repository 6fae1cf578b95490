#include "verify/pages/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "reference/base/error.h"

namespace scotty::verify {
namespace {

/// The text between `before` and `after`, if the whole line has that form.
std::optional<std::string_view> between(std::string_view line, std::string_view before,
                                        std::string_view after) {
    const std::size_t start = line.find_first_not_of(' ');
    if (start == std::string_view::npos) return {};
    line.remove_prefix(start);
    if (!line.starts_with(before) || !line.ends_with(after)) return {};
    return line.substr(before.size(), line.size() - before.size() - after.size());
}

std::string_view file_named(std::string_view name) {
    const auto found = page_files().find(name);
    if (found == page_files().end()) {
        throw reference::Error::internal(fmt::format("verify/pages/web/ has no file {}", name));
    }
    return found->second;
}

std::string with_parts(std::string_view name, std::string_view line,
                       const std::map<std::string, std::string>& parts) {
    if (const auto file = between(line, R"(<link rel="stylesheet" href=")", R"(">)")) {
        return fmt::format("<style>\n{}</style>", file_named(*file));
    }
    if (const auto file = between(line, R"(<script src=")", R"("></script>)")) {
        return fmt::format("<script>\n{}</script>", file_named(*file));
    }
    const auto part = between(line, "<!-- part ", " -->");
    if (!part) return std::string(line);
    const auto found = parts.find(std::string(*part));
    if (found == parts.end()) {
        throw reference::Error::internal(fmt::format("{}: nobody made the part {}", name, *part));
    }
    return found->second;
}

}  // namespace

std::string filled_page(std::string_view name, const std::map<std::string, std::string>& parts) {
    std::string page;
    std::string_view rest = file_named(name);
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        page += with_parts(name, rest.substr(0, end), parts) + "\n";
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return page;
}

std::string html_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string json_for_script(const nlohmann::json& data) {
    // A name from a file need not be UTF-8, but the page has to be written all the same.
    std::string out;
    for (const char c : data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
        if (c == '<') {
            out += "\\u003c";
        } else {
            out += c;
        }
    }
    return out;
}

}  // namespace scotty::verify
