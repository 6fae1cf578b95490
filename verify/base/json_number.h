/// Numbers that JSON cannot express.
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"

namespace scotty::verify {

/// A number that is not finite becomes the string "NaN", "Infinity" or "-Infinity".
inline nlohmann::ordered_json json_number(double value) {
    if (std::isfinite(value)) return value;
    if (std::isnan(value)) return "NaN";
    return value > 0.0 ? "Infinity" : "-Infinity";
}
/// Null if there is none.
inline nlohmann::ordered_json json_number(const std::optional<float>& value) {
    return value ? json_number(static_cast<double>(*value)) : nlohmann::ordered_json(nullptr);
}

/// The id of a node, ray, level or the like; null if it means none.
inline nlohmann::ordered_json json_id(std::uint32_t value) {
    static_assert(reference::kNone == reference::kNotApplicable);
    return value == reference::kNone ? nlohmann::ordered_json(nullptr)
                                     : nlohmann::ordered_json(value);
}

}  // namespace scotty::verify
