/// --shard I/N: one of N parts of a list, the same on every machine.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>

namespace scotty::verify {

struct Shard {
    std::size_t index = 0;  ///< from 0
    std::size_t count = 1;

    /// Items are dealt out like cards, so that neighbours, which take about as long, are separated.
    bool has(std::size_t item) const { return item % count == index; }
    /// Items stay in runs of neighbours, which share preparation.
    bool has(std::size_t item, std::size_t of) const { return item * count / of == index; }
};

/// "2/4" is the second of four; empty means everything. Throws bad_input.
Shard parse_shard(const std::string& text);
void add_shard_option(CLI::App& command, std::string& text);

}  // namespace scotty::verify
