/// What the numbers in a buffer mean.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>

#include "verify/diff/diff_parts.h"

namespace scotty::verify {

const Layout& layout_of(std::string_view buffer) {
    static const Layout none;
    static const std::map<std::string_view, Layout> layouts = [] {
        const std::vector<Field> ray{
            {"origin.x", true},    {"origin.y", true},    {"origin.z", true},    {"t_min", true},
            {"direction.x", true}, {"direction.y", true}, {"direction.z", true}, {"t_max", true}};
        const std::vector<Field> hit{{"t", true}, {"primitive", false}, {"u", true}, {"v", true}};
        const std::vector<Field> colour{{"r", true}, {"g", true}, {"b", true}};
        const std::vector<Field> number{{"", false}};
        const std::vector<Field> distance{{"", true}};
        std::map<std::string_view, Layout> out;
        for (const char* name : {"rays", "shadow_rays"}) out[name] = {Row::ray, ray};
        for (const char* name : {"path_hits", "shadow_hits", "merged"}) out[name] = {Row::ray, hit};
        for (const char* name : {"throughput", "radiance", "potential"}) {
            out[name] = {Row::ray, colour};
        }
        for (const char* name : {"image", "filtered"}) out[name] = {Row::pixel, colour};
        for (const char* name : {"pixel", "sample", "depth", "flags", "hit_counts"}) {
            out[name] = {Row::ray, number};
        }
        for (const char* name : {"minimum", "lowered"}) out[name] = {Row::ray, distance};
        for (const char* name : {"node_counts", "queue_offsets", "block_offsets", "queue"}) {
            out[name] = {Row::node, number};
        }
        for (const char* name : {"child_counts", "child_offsets", "child_queue"}) {
            out[name] = {Row::child_node, number};
        }
        // Little endian: the low word comes first.
        out["packed_hits"] = {Row::ray, {{"primitive", false}, {"t", true}}};
        out["hits"] = {Row::ray, {{"t", true}, {"primitive", false}}};
        return out;
    }();
    const auto found = layouts.find(buffer);
    return found == layouts.end() ? none : found->second;
}

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
