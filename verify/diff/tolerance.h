/// What `--arithmetic fast` may change, stated per array.
///
/// Approximate division and square root and contraction move a number by a few units in the last
/// place; where that flips a comparison, a path forks and everything after it is another path's. So
/// an array has two figures: how far a number may be off, and what share of rows may be farther.
#pragma once

#include <string_view>
#include <vector>

#include "verify/diff/diff_parts.h"

namespace scotty::verify {

struct Tolerance {
    std::string_view buffer;
    /// Of the larger magnitude of the two numbers, or of a hundredth of the field's largest
    /// finite magnitude in the array, where that is more.
    double relative = 0.0;
    /// Of the rows: rays, pixels, or entries of queues and hit lists.
    double share = 0.0;
};

/// One for every buffer that a stage shows; docs/captures.md prints the same table.
const std::vector<Tolerance>& tolerances();

/// Equal within the buffer's tolerance: within_tolerance, else differs, led by the row that is
/// farthest off.
Comparison compare_within_tolerance(const BufferPair& pair);

}  // namespace scotty::verify
