/// Captured stages run again by a back end: one alone, or each on A's inputs (an isolated diff).
#pragma once

#include <string>

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

/// Runs one stage and compares with what was captured of it. Throws bad_input where there is no
/// such stage, or the capture lacks what it needs.
DiffReport replay_stage(const Capture& capture, const std::string& stage, const Backend& backend);

/// Every stage of the capture alone.
DiffReport diff_isolated(const Capture& capture, const Backend& backend, DiffOptions options);

/// A fresh run from the capture's input.
DiffReport diff_with_run(const Capture& capture, const Backend& backend, DiffOptions options);

}  // namespace scotty::verify
