/// What the checker of loads and stores costs for the emulator and for the CUDA text, beside the
/// same unchecked.
#pragma once

#include "verify/bench/bench_simt.h"

namespace scotty::verify {

struct CheckBenchPart {
    std::string name;    ///< of the back end
    double limit = 0.0;  ///< what the ratio may be
    Spread plain{};      ///< seconds a render
    Spread checked{};    ///< of scotty-checked

    double ratio() const { return checked.median / plain.median; }
    bool within() const { return ratio() <= limit; }
};

struct CheckBenchReport : BenchSubject {
    std::vector<CheckBenchPart> parts;

    bool passed() const;
};

/// Seconds of each render of render_by_turns(): "emulator" and "simt", as this program runs them.
nlohmann::json render_seconds(const reference::Scene& scene, const BenchSettings& settings);

/// Round by round: here, and then in a scotty-checked of its own, started as `command`, which
/// prints its render_seconds(). Throws missing_environment where that cannot be had.
CheckBenchReport bench_check(const reference::Scene& scene, const BenchSettings& settings,
                             const std::string& command);

std::string table(const CheckBenchReport& report);
nlohmann::json to_json(const CheckBenchReport& report);

}  // namespace scotty::verify
