/// The folder golden/: its manifest, and what is wrong with it.
///
/// Its files are made by propose_golden() elsewhere and moved in by approve_golden() (see
/// golden_proposal.h); nothing else writes there.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "verify/golden/golden_case.h"
#include "verify/golden/waivers.h"

namespace scotty::verify {

struct GoldenEntry {
    std::string name;
    /// All that decides what the files hold (settings_of()): other settings, and they are stale.
    nlohmann::ordered_json settings;
    std::map<std::string, std::string> files;  ///< path within golden/ to XXH64 of its bytes
    std::string command, commit, made_with, reason;
};

struct Manifest {
    std::vector<GoldenEntry> entries;

    /// Null where there is none.
    const GoldenEntry* find(const std::string& name) const;
};

/// What an entry of that case says under "settings".
nlohmann::ordered_json settings_of(const GoldenCase& golden, const reference::Scene& scene);

std::filesystem::path image_path(const std::string& name);   ///< "images/NAME.exr"
std::filesystem::path ledger_path(const std::string& name);  ///< "ledgers/NAME.txt"
/// The entry of the manifest that is of no case: the hashes of small runs (hash_book.h).
inline constexpr const char* kHashesName = "hashes";
inline constexpr const char* kHashesFile = "hashes.txt";

nlohmann::ordered_json to_json(const GoldenEntry& entry);
/// Throws bad_input naming `where` and the member.
GoldenEntry parse_entry(const std::string& where, const nlohmann::json& object);
/// Of manifest.json in that folder. Throws bad_input naming file and element.
Manifest read_manifest(const std::filesystem::path& golden);
/// Entries by name; written beside the target and renamed.
void write_manifest(const std::filesystem::path& golden, const Manifest& manifest);

/// XXH64 of a file's bytes; throws bad_input naming it.
std::string checksum(const std::filesystem::path& file);

/// The folder `golden` with a manifest, beside or above the running program, else at or above the
/// current folder. Throws bad_input where there is none.
std::filesystem::path find_golden_folder();

enum class GoldenProblem {
    missing,    ///< a case without an entry, or an entry without its file
    orphaned,   ///< a file without an entry, or an entry without a case
    stale,      ///< made for another scene, other parameters or by another generator
    corrupted,  ///< not the bytes that the manifest has the checksum of
    waiver      ///< expired, or of a case that does not exist
};
const char* to_string(GoldenProblem problem);

struct GoldenFinding {
    GoldenProblem problem;
    std::string name;     ///< of the case; empty where it has none
    std::string file;     ///< within golden/; empty where it is about an entry
    std::string text;     ///< one sentence
    std::string way_out;  ///< what to do
};

/// Everything that is wrong with the folder, by case and then the rest. Renders nothing.
/// Throws bad_input where manifest or waivers cannot be read.
std::vector<GoldenFinding> check_golden(const std::filesystem::path& golden,
                                        const std::vector<GoldenCase>& cases, const Date& today);

}  // namespace scotty::verify
