/// One launch as arrays of the page: what its buffers hold, and what the model says of it.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "verify/pages/page_arrays.h"
#include "verify/queues/queues.h"
#include "verify/queues/queues_visits.h"

namespace scotty::verify {

/// Of a level kernel `queue`, `lengths`, `offsets`, `claimed`, `block_offsets`, `child_queue`,
/// `child_counts`, `child_offsets`, `child_room`, `child_claimed`, `rays`, `minimum` and the arrays
/// of VisitLog; of any other launch what a history shows of it (`merged`, `radiance`, ...). Queues
/// are without gaps, node by node. What was not captured is left out. `log`: of the launch's
/// traversal, or null.
nlohmann::json launch_arrays(PageArrays& pool, const Queues& queues, const StageRecord& stage,
                             const TraversalLog* log);

/// Entries of both runs paired by the model, of the nodes where any is not the same: `node`,
/// `pairs` by node, and by pair `a` and `b` (position + 1; 0: none), `change`, `what` (1 the ray,
/// 2 the minimum). Empty where there are none.
nlohmann::json pair_arrays(PageArrays& pool, const Queues& a, const StageRecord& a_stage,
                           const Queues& b, const StageRecord& b_stage);

}  // namespace scotty::verify
