/// A schedule of a launch's blocks that switches in their middle, as data and as a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace scotty::emulation::simt {

/// `block` pauses before its `access`-th access to device memory (counted from 1 over all its
/// threads), and `to` goes on. Access 0 means the end of `block`.
struct Switch {
    std::uint32_t block = 0;
    std::uint32_t access = 0;
    std::uint32_t to = 0;

    bool operator==(const Switch&) const = default;
};

/// Block 0 begins. A block goes on until a switch says otherwise, it only waits for others, or it
/// is over; then the lowest that can run follows. Without switches, blocks run one after the other.
struct Interleaving {
    std::string kernel;
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;  ///< per block
    std::vector<Switch> switches;

    bool operator==(const Interleaving&) const = default;
};

/// "block 0 stands before access 5, block 1 goes on".
std::string to_text(const Switch& change);
/// Lines of words, which people read too.
std::string to_text(const Interleaving& interleaving);
/// Throws bad_input naming the file and the line.
Interleaving read_interleaving(const std::filesystem::path& file);
/// Writes beside the file and renames; throws bad_input naming it.
void write_interleaving(const std::filesystem::path& file, const Interleaving& interleaving);

}  // namespace scotty::emulation::simt
