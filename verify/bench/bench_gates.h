/// How often each image gate rejects a render with a known fault, and one with none.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "verify/images/image_gates.h"
#include "verify/images/planted_faults.h"

namespace scotty::verify {

struct GateBenchSettings {
    SyntheticSettings image;  ///< the seed is the first trial's
    std::uint32_t golden_factor = 16;
    std::uint32_t trials = 50;
    double false_alarm = 1e-4;  ///< for one image
    std::function<void(const std::string&)> progress;
};

struct GateBenchRow {
    std::string fault;
    bool should_pass = false;
    bool light_tailed = true;  ///< as which it was judged
    /// Trials that the gate rejected: layout, finite, global, tile, pixel.
    std::array<std::uint32_t, 5> rejected{};
    std::uint32_t rejected_by_any = 0;
};

struct GateBenchReport {
    GateBenchSettings settings;
    std::vector<GateBenchRow> rows;
    double seconds = 0.0;
};

GateBenchReport bench_gates(const GateBenchSettings& settings);

std::string table(const GateBenchReport& report);
nlohmann::json to_json(const GateBenchReport& report);

}  // namespace scotty::verify
