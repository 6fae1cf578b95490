/// Failures of one kind belong together: one fault in a kernel breaks the same invariant in
/// hundreds of places.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "verify/report/report.h"

namespace scotty::verify {

/// All failures of one invariant at one stage, whichever bounce, light sample or level it was of.
struct FailureGroup {
    std::string invariant;
    std::string stage;                 ///< stage_family() of all of them
    std::vector<std::size_t> members;  ///< their places in placed_failures(), never empty
    std::vector<std::string> scenes;   ///< each once, in order
    std::size_t configurations = 0;    ///< pairs of scene and configuration
};

/// "bounce*/level*/intersect" of "bounce1/level3/intersect", in whichever batch; a name without a
/// slash as it is.
std::string stage_family(const std::string& stage);

/// In the order of their first members, so that the one to mend first leads.
std::vector<FailureGroup> failure_groups(const std::vector<PlacedFailure>& failures);

/// A failure whole: scene and configuration, place, values, and the commands.
std::string to_text(const PlacedFailure& placed);

/// A line for each group, no wider than 80 columns; empty where there is but one failure.
std::string to_text(const std::vector<FailureGroup>& groups);

}  // namespace scotty::verify
