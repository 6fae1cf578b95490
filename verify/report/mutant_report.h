/// Planted faults, what caught each, and the score.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/stage_observer.h"

namespace scotty::verify {

/// What has to find a fault.
struct ExpectedCatch {
    std::string check;              ///< MutantCatch::check
    std::string stage;              ///< as a regular expression, of the whole name
    std::string says;               ///< the same of a part of what is said; empty: anything
    std::vector<std::string> also;  ///< checks that have to fail besides
};

struct PlantedFault {
    int number = 0;  ///< of its switch
    std::string name;
    std::string what;    ///< in one sentence
    std::string file;    ///< from the project's root: "gpu/kernels/intersect.h"
    std::string defect;  ///< of a published program that had it; mostly empty
    std::string run;     ///< the arguments of the command that has to catch it
    ExpectedCatch expect;
    /// Why it is not in this program: the kernels have changed so that the text that it replaces is
    /// not there once any more. Empty: it is there.
    std::string unapplied{};

    /// Of the back end whose kernels have it.
    std::string backend() const { return file.starts_with("gpu/") ? "simt" : "emulator"; }
    /// A fault in what the back ends share is in each of them.
    bool is_of(const std::string& other) const {
        return file.starts_with("reference/") ? other != "cuda" : other == backend();
    }
};

/// Nothing is planted, but little room, odd sizes or a strange order: it has to pass.
struct HostileCondition {
    std::string name;
    std::string what;
    std::string run;
};

/// What a command said that has found something.
struct MutantCatch {
    /// Failure::invariant of the failure that leads; where that is only "error", the kind of error
    /// (kind_of_error()). Empty: nothing was found.
    std::string check;
    std::string stage;                                 ///< or the kernel, where the process ended
    std::uint32_t launch = reference::kNotApplicable;  ///< how soon
    std::string place;  ///< a line of the text, or node, block and ray
    std::string says;
    std::vector<std::string> checks;  ///< of all failures
};

struct MutantResult {
    PlantedFault fault;
    MutantCatch found;
    double seconds = 0.0;
    std::string why_not;  ///< it counts as caught; empty: it does

    bool caught() const { return why_not.empty(); }
};

struct HostileResult {
    HostileCondition condition;
    double seconds = 0.0;
    std::string failure;  ///< empty: passed, as it has to
};

struct MutantReport {
    std::vector<MutantResult> faults;
    std::vector<HostileResult> hostile;
    std::string shard;  ///< "2/4"; empty: all
    double seconds = 0.0;

    std::size_t caught() const;
    std::size_t unapplied() const;
    bool passed() const;
};
/// Lines of 80 columns at most, but for commands, which can be pasted.
std::string to_text(const MutantReport& report);
/// Words in lines of 80 columns, nine blanks before each.
std::string indented(const std::string& text);
/// "mutants: 96 of 96 caught" and the same of hostile conditions, a line each.
std::string score(const MutantReport& report);
nlohmann::json to_json(const MutantReport& report);

/// Whether a JSON document says that it is one of to_json()'s.
bool is_mutant_report(const nlohmann::json& object);
/// Of the content of `path`. Throws bad_input naming it.
MutantReport read_mutants(const std::string& path, const nlohmann::json& object);
/// Of all shards: names[i] is the file of parts[i]. Throws bad_input where one is missing or there
/// twice.
MutantReport join(const std::vector<MutantReport>& parts, const std::vector<std::string>& names);

}  // namespace scotty::verify
