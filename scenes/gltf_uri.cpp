#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <optional>
#include <string_view>

#include "reference/base/error.h"
#include "scenes/gltf_bytes.h"

namespace scotty::scenes {

using reference::Error;

namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/// "my%20data.bin" as "my data.bin". A % that begins no code stays.
std::string percent_decoded(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool is_code = text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 &&
                             hex_digit(text[i + 2]) >= 0;
        if (is_code) {
            out += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
            i += 2;
        } else {
            out += text[i];
        }
    }
    return out;
}

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    return c == '/' || c == '_' ? 63 : -1;
}

/// Nothing where a character is no digit of base64. Padding may be missing.
std::optional<std::string> base64_decoded(std::string_view text) {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    std::string out;
    out.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : text) {
        const int digit = base64_digit(c);
        if (digit < 0) return std::nullopt;
        bits = (bits << 6u) | static_cast<std::uint32_t>(digit);
        held += 6;
        if (held < 8) continue;
        held -= 8;
        out += static_cast<char>((bits >> static_cast<unsigned>(held)) & 0xffu);
    }
    return out;
}

GltfBytes open_data(std::string_view uri, const std::string& place) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) {
        throw Error::bad_input(place, "uri: a data: uri without a comma before its data");
    }
    const std::string_view kind = uri.substr(0, comma);
    const std::string_view data = uri.substr(comma + 1);
    if (kind.size() < 7 || kind.substr(kind.size() - 7) != ";base64") {
        return GltfBytes::of_memory(percent_decoded(data));
    }
    auto bytes = base64_decoded(data);
    if (!bytes) throw Error::bad_input(place, "uri: the data: uri is not base64");
    return GltfBytes::of_memory(*std::move(bytes));
}

/// "http:", "file:" and the like; a single letter is a drive, not a scheme.
bool has_scheme(std::string_view uri) {
    std::size_t length = 0;
    while (length < uri.size() && (std::isalnum(static_cast<unsigned char>(uri[length])) != 0 ||
                                   uri[length] == '+' || uri[length] == '.')) {
        ++length;
    }
    return length > 1 && length < uri.size() && uri[length] == ':';
}

}  // namespace

GltfBytes open_gltf_uri(const std::string& uri, const std::string& folder,
                        const std::string& place) {
    if (uri.rfind("data:", 0) == 0) return open_data(uri, place);
    if (has_scheme(uri)) {
        throw Error::bad_input(place, fmt::format("uri: only files and data: are supported, found "
                                                  "'{:.60}'",
                                                  uri));
    }
    // A file may also be called as the uri says to the letter.
    for (const std::string& name : {percent_decoded(uri), uri}) {
        if (name.empty() || name.find('\0') != std::string::npos) continue;
        const std::filesystem::path file = std::filesystem::path(folder) / name;
        std::error_code ignored;
        if (std::filesystem::is_regular_file(file, ignored)) {
            return GltfBytes::of_file(file.string());
        }
    }
    throw Error::bad_input(place, fmt::format("uri: no such file: '{:.200}'", uri));
}

}  // namespace scotty::scenes
