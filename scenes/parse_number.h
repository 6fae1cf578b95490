/// Numbers in text files, independent of the locale.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace scotty::scenes {

/// The finite number that is all of `word`. Nothing for words, "nan", "inf" and numbers too large
/// for a double; those too small for one are rounded.
inline std::optional<double> parse_finite(std::string_view word) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    double value = 0.0;
    const char* end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(word.data(), end, value);
    if (stop != end || status == std::errc::invalid_argument) return std::nullopt;
    // from_chars does not say on which side it is out of range.
    if (status != std::errc()) value = std::strtod(std::string(word).c_str(), nullptr);
    return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

}  // namespace scotty::scenes
