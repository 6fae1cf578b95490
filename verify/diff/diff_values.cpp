/// Numbers of buffers as reports show them.
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "verify/diff/diff_parts.h"

namespace scotty::verify {

std::string value_text(std::uint32_t bits, bool is_float) {
    return is_float ? fmt::format("{:#010x} ({:.9g})", bits, std::bit_cast<float>(bits))
                    : fmt::format("{:#x} ({})", bits, bits);
}

std::optional<std::uint64_t> ulps_between(std::uint32_t a, std::uint32_t b) {
    if (std::isnan(std::bit_cast<float>(a)) || std::isnan(std::bit_cast<float>(b))) {
        return std::nullopt;
    }
    // Along the number line: negative floats count downwards.
    const auto place = [](std::uint32_t bits) {
        const auto magnitude = static_cast<std::int64_t>(bits & 0x7fffffffu);
        return (bits >> 31) != 0 ? -magnitude - 1 : magnitude;
    };
    const std::int64_t gap = place(a) - place(b);
    return static_cast<std::uint64_t>(gap < 0 ? -gap : gap);
}

}  // namespace scotty::verify
