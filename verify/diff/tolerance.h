/// What `--arithmetic fast` may change, by the tolerances in reference/contract/buffers.h.
///
/// Approximate division and square root and contraction change a number by a few units in the last
/// place; if that flips a comparison, a path forks and everything after it is another path's. So an
/// array has two figures: how far a number may be off, and what share of rows may be farther.
#pragma once

#include "verify/diff/diff_parts.h"

namespace scotty::verify {

/// Equal within the buffer's tolerance: within_tolerance; otherwise differs, led by the row that is
/// farthest off.
Comparison compare_within_tolerance(const BufferPair& pair);

}  // namespace scotty::verify
