/// A captured run on a time line: Chrome trace JSON, which Perfetto and chrome://tracing open.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "verify/queues/queues.h"
#include "verify/queues/queues_history.h"

namespace scotty::verify {

/// Time is logical, so that two runs can be laid side by side: a launch of a level kernel takes one
/// unit (shown as a microsecond) for each entry of its queues, any other one for each thread block.
/// Launches are slices of one track, queue lengths counters; each history is a track of its own,
/// with a slice where the ray's entry lies in its launch, and a flow from one to the next.
nlohmann::ordered_json to_trace(const Queues& queues, const std::vector<RayHistory>& histories);

}  // namespace scotty::verify
