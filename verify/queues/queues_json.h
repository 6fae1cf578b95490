/// A ray's history as a document: what `scotty queues --ray R --json` prints, and what the page
/// puts together for any ray (verify/pages/web/queues_history.js).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "verify/queues/queues_diff.h"
#include "verify/queues/queues_history.h"

namespace scotty::verify {

/// {batch, ray, pixel, sample, bounces: [{bounce, traversal, lights, ...}], ...}; a traversal is
/// {name, ray, visits: [{launch, node, position, children | leaf, ...}], merged, ...}. The members
/// are those of queues_history.h by their names; null where there is nothing, a ray is
/// {origin, direction, t_min, t_max}, floats are exact in nine digits and words where they are not
/// finite.
nlohmann::ordered_json to_json(const RayHistory& history);

/// {batch, ray, a: history, b: history, differences: [{traversal, level, node, change, what:
/// [{what, change, a, b}]}]}, the last of visits that are not the same.
nlohmann::ordered_json to_json(const RayHistory& a, const RayHistory& b);

}  // namespace scotty::verify
