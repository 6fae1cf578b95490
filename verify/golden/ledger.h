/// The stage ledger of a small run: one line a stage and buffer, with the hash of its canonical
/// form. It is text, so that it diffs in git and names the first stage that changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "verify/capture/capture.h"

namespace scotty::verify {

struct LedgerLine {
    std::string stage;   ///< "bounce1/light0/level3/intersect"
    std::string buffer;  ///< an output of that stage
    std::string hash;    ///< 16 hexadecimal digits

    bool operator==(const LedgerLine&) const = default;
};

struct Ledger {
    /// Of what: "scene", "bvh" (hashes) and "parameters" (JSON), in that order.
    std::vector<std::pair<std::string, std::string>> header;
    std::vector<LedgerLine> lines;  ///< in launch order
};

/// All outputs of all stages; inputs are earlier outputs.
Ledger ledger_of(const Capture& capture);

std::string to_text(const Ledger& ledger);
/// Throws bad_input naming the file and line.
Ledger read_ledger(const std::filesystem::path& file);

struct LedgerComparison {
    std::size_t compared = 0;  ///< lines
    std::size_t differing = 0;
    /// The first line that differs; empty where none does. `buffer` is empty where a whole stage is
    /// missing or new, both are where the header differs.
    std::string stage, buffer;
    std::string sentence;

    bool passed() const { return sentence.empty(); }
};

/// Exactly: the same header, the same stages in the same order, the same hashes.
LedgerComparison compare_ledgers(const Ledger& golden, const Ledger& found);

}  // namespace scotty::verify
