/// The golden images and ledgers as part of a verification.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "verify/backends/backend.h"
#include "verify/report/report.h"

namespace scotty::verify {

struct GoldenSettings {
    std::string folder;               ///< empty: find_golden_folder()
    std::vector<std::string> scenes;  ///< as asked for; those with a golden case are judged
    std::size_t threads = 0;
    /// Probability that the images of the whole run fail though nothing is wrong. Seeds are fixed:
    /// the same build says the same every time.
    double false_alarm = 1e-4;
    /// As in VerifySettings; `first_unit` is the first case's.
    std::function<bool(std::size_t unit)> has_unit;
    std::size_t first_unit = 0;
    std::function<void(const std::string& name, std::size_t done, std::size_t total)> progress;
    /// Called after every case with the report so far: true leaves out the others, whose numbers go
    /// to Report::unjudged_units.
    std::function<bool()> stop;
};

/// How many golden cases these scenes have.
std::size_t units_of_golden(const GoldenSettings& settings);

/// Judges every case and adds what came of it to the report. What is wrong with the golden files,
/// a missing one included, is a failure, never a skip.
void verify_golden(const GoldenSettings& settings, const Backend& backend, Report& report);

}  // namespace scotty::verify
