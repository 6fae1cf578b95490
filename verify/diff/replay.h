/// A back end runs captured stages again: one alone, or each on A's inputs (an isolated diff).
#pragma once

#include <string>

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

/// Runs one stage and compares it with the capture. Throws bad_input if there is no such stage, or
/// the capture lacks its inputs.
DiffReport replay_stage(const Capture& capture, const std::string& stage, const Backend& backend);

/// Runs every stage of the capture alone.
DiffReport diff_isolated(const Capture& capture, const Backend& backend, DiffOptions options);

/// Compares with a fresh run from the capture's input.
DiffReport diff_with_run(const Capture& capture, const Backend& backend, DiffOptions options);

}  // namespace scotty::verify
