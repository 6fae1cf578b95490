/// Golden files made anew: rendered into a folder of their own, looked at, and moved in one by one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "verify/golden/golden.h"
#include "verify/golden/hash_book.h"

namespace scotty::verify {

struct ProposalSettings {
    std::filesystem::path golden;  ///< what is compared with; never written
    std::filesystem::path output;  ///< made where it is missing; not inside `golden`
    std::size_t threads = 0;       ///< 0: all
    bool ledger_only = false;  ///< the image stays the golden one: a stage or buffer has changed
    std::string command;       ///< as given, for the manifest
    std::string commit;        ///< of the source tree, for the manifest
    /// What is being done, and how far the samples are.
    std::function<void(const std::string& what, std::uint64_t done, std::uint64_t total)> progress;
};

/// What would change if a case were approved.
struct Proposal {
    enum class Change { added, changed, unchanged };

    std::string name;
    Change image = Change::added;
    Change ledger = Change::added;
    std::uint64_t pixels_changed = 0;
    double largest_change = 0.0;  ///< of a mean, radiance
    double largest_z = 0.0;       ///< the same in standard deviations of both; 0 where unknown
    std::uint64_t lines_changed = 0;
    std::string first_line;         ///< of the ledger that changes: one sentence
    std::string reason_to_propose;  ///< what check_golden() has to say about it now; may be empty
    double noise = 0.0;  ///< of the new image: standard deviation of the mean of all pixels, as a
                         ///< share of that mean
};
const char* to_string(Proposal::Change change);

/// Renders image and ledger of a case into `output`. Can be interrupted and called again: the
/// image's sums are kept there. Never writes to `golden`.
Proposal propose_golden(const GoldenCase& golden, const ProposalSettings& settings);

/// "cornell: image changed in 12 pixels ..." with the command that approves it.
std::string to_text(const std::vector<Proposal>& proposals);
nlohmann::ordered_json to_json(const std::vector<Proposal>& proposals);

/// Moves the proposal of one case into `golden`: its files, then its entry in the manifest, each by
/// a rename. Touches nothing else. Throws bad_input where there is no such proposal, where it was
/// made for other settings than the case has now, where its files are not those that were
/// proposed, and where no reason is given.
void approve_golden(const GoldenCase& golden, const std::filesystem::path& golden_folder,
                    const std::filesystem::path& output, const std::string& reason);

/// The same for the hashes of small runs: written into `output` beside an entry of their own.
struct HashProposal {
    std::uint64_t added = 0, changed = 0, gone = 0;
    std::uint64_t in_all = 0;
    std::string first;  ///< what the first one that changes is of

    bool changes() const { return added + changed + gone != 0; }
};
HashProposal propose_hashes(const Hashes& hashes, const ProposalSettings& settings);
/// "hashes: 3 of 512 changed, ..." with the command that approves them.
std::string to_text(const HashProposal& proposal);
nlohmann::ordered_json to_json(const HashProposal& proposal);
/// Throws as approve_golden() does.
void approve_hashes(const std::filesystem::path& golden_folder, const std::filesystem::path& output,
                    const std::string& reason);

/// Of a golden folder; none where its manifest does not list them. Throws bad_input where the file
/// is not what the manifest says.
std::optional<Hashes> golden_hashes(const std::filesystem::path& golden_folder);

}  // namespace scotty::verify
