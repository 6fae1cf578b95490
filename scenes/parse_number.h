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

/// The float nearest to the number that is all of `word`, rounded once. Nothing for words, "nan",
/// "inf" and numbers too large for a float.
inline std::optional<float> parse_finite_float(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    float value = 0.0f;
    const char* end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(word.data(), end, value);
    if (stop != end || status == std::errc::invalid_argument) return std::nullopt;
    if (status != std::errc()) value = std::strtof(std::string(word).c_str(), nullptr);
    return std::isfinite(value) ? std::optional<float>(value) : std::nullopt;
}

/// Whether `word` is how programs write a number that is not finite: "nan", "-inf", "1.#QNAN".
inline bool is_not_finite(std::string_view word) {
    if (!word.empty() && (word.front() == '-' || word.front() == '+')) word.remove_prefix(1);
    const auto begins = [&](std::string_view wanted) {
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            if (i >= word.size() || (word[i] | 0x20) != wanted[i]) return false;
        }
        return true;
    };
    return begins("nan") || begins("inf") || word.substr(0, 3) == "1.#";
}

}  // namespace scotty::scenes
