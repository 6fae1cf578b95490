/// The invariants of a captured run, launch by launch: which were asked, and what they said.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reference/contract/stage_observer.h"
#include "verify/capture/capture.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

struct CheckedRun {
    /// False where a part of the run was captured: a launch cannot be held to what came before.
    bool asked = false;
    std::map<std::uint32_t, std::vector<Failure>> failures;  ///< by launch
    std::uint64_t not_kept = 0;                              ///< failures beyond the first 1000
};
/// Runs verify/invariants/invariants.h over the captured stages.
CheckedRun check_capture(const Capture& capture);

}  // namespace scotty::verify
