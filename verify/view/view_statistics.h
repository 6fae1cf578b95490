/// What a render's launches say: time by stage, rays by kind, queue lengths by level.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "reference/contract/launch_record.h"

namespace scotty::verify {

/// {"stages": [[label, seconds, launches]], "levels": [[level, seconds]], "rays": {"primary": n,
/// "bounce": n, "shadow": n}, "queues": [[entries of level 0, of level 1, ...]]} with a list of
/// queue lengths for each kind of ray: primary, bounce, shadow. Seconds are 0 where launches are
/// not timed.
nlohmann::json launch_statistics(std::span<const reference::LaunchRecord> launches);

}  // namespace scotty::verify
