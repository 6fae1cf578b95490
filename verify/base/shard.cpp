#include "verify/base/shard.h"

#include <fmt/format.h>

#include <charconv>

#include "reference/base/error.h"

namespace scotty::verify {

Shard parse_shard(const std::string& text) {
    if (text.empty()) return {};
    const char* const end = text.data() + text.size();
    Shard shard;
    const auto first = std::from_chars(text.data(), end, shard.index);
    const bool parted = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
    const auto second = parted ? std::from_chars(first.ptr + 1, end, shard.count) : first;
    if (!parted || second.ec != std::errc() || second.ptr != end || shard.index < 1 ||
        shard.index > shard.count) {
        throw reference::Error::bad_input(
            "--shard", fmt::format("expected I/N with I from 1 to N, found '{}'", text));
    }
    --shard.index;
    return shard;
}

void add_shard_option(CLI::App& command, std::string& text) {
    command.add_option("--shard", text, "one of N parts, from 1/N to N/N")->type_name("I/N");
}

}  // namespace scotty::verify
