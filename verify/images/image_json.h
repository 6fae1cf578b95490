/// An image's verdict as JSON, the same wherever it is shown.
#pragma once

#include <nlohmann/json.hpp>

#include "verify/images/image_gates.h"

namespace scotty::verify {

/// {"gates": [...], "not_judged_by": {...}, "worst": [...]}
nlohmann::ordered_json to_json(const ImageVerdict& verdict);

}  // namespace scotty::verify
