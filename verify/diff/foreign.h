/// Judges the run of another program that capture_writer.h has recorded.
#pragma once

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

/// The back end runs each level alone on the capture's tree, rays and queues; the capture has to
/// hold the rays that it pushes to each child. Hits are held to those that it finds in the leaves
/// whose queues are given, and answers to a tree of its own. The other program has arithmetic of
/// its own: what its float tests may decide either way is excused and counted. Bits are never
/// compared, nor is the order.
///
/// What the capture does not hold is listed in DiffReport::not_given. Throws bad_input where the
/// capture is not of another program, or has no rays.
DiffReport diff_foreign(const Capture& capture, const Backend& backend, DiffOptions options);

}  // namespace scotty::verify
