/// Known failures that are let pass for a while: golden/waivers.json.
///
/// A waiver has a reason and an end. When the end has come it is an error of its own, and one that
/// no failure needs any more is reported.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace scotty::verify {

/// "2026-01-31": ordered as text.
using Date = std::string;
/// Of the system's clock, UTC.
Date today();

struct Waiver {
    std::string golden;  ///< the case
    std::string gate;    ///< "layout", "finite", "global", "tile", "pixel"; empty: a stage
    std::string stage;   ///< of the ledger, * and ? allowed; empty: a gate
    std::string device;  ///< the back end, or "*"
    std::string reason;  ///< a sentence
    Date expires;        ///< the last day on which it holds

    bool has_expired(const Date& day) const { return day > expires; }
};
/// "the waiver of gate 'pixel' for case 'coil' on 'cuda' (reason: ...)"
std::string to_string(const Waiver& waiver);

/// None where the file does not exist. Throws bad_input naming file, waiver and member: not JSON, a
/// member missing, unknown or of another form, neither or both of gate and stage.
std::vector<Waiver> read_waivers(const std::filesystem::path& golden);

/// Waivers in use, and whether they were of any.
class WaiverBook {
 public:
    WaiverBook(std::vector<Waiver> waivers, Date day);

    /// The first that covers a failed gate or stage; null where none does. Expired ones cover
    /// nothing. Remembers that it was used.
    const Waiver* cover_gate(const std::string& golden, const std::string& gate,
                             const std::string& device);
    const Waiver* cover_stage(const std::string& golden, const std::string& stage,
                              const std::string& device);

    /// Those that have expired.
    std::vector<Waiver> expired() const;
    /// Those of that device and of one of those cases that covered nothing, and have not expired.
    std::vector<Waiver> unused(const std::vector<std::string>& goldens,
                               const std::string& device) const;

 private:
    template <class Matches>
    const Waiver* cover(const std::string& golden, const std::string& device,
                        const Matches& matches);

    std::vector<Waiver> waivers_;
    std::vector<char> used_;
    Date day_;
};

}  // namespace scotty::verify
