/// A pipeline against the golden image and ledger of a case.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "verify/backends/backend.h"
#include "verify/golden/golden.h"
#include "verify/golden/ledger.h"
#include "verify/golden/pipeline_image.h"
#include "verify/golden/waivers.h"
#include "verify/images/image_gates.h"

namespace scotty::verify {

/// What a case is judged by, read and found whole.
struct GoldenTruth {
    MeasuredImage image;
    Ledger ledger;
};
/// Throws bad_input where the files are missing, stale or corrupted, with the way out: a missing
/// golden fails.
GoldenTruth read_golden(const std::filesystem::path& golden, const GoldenCase& golden_case,
                        const reference::Scene& scene);

/// What the pipeline makes of a case.
struct GoldenRun {
    PipelineImage image;
    Ledger ledger;
};
GoldenRun run_golden(const GoldenCase& golden_case, const reference::Scene& scene,
                     const Backend& backend, std::size_t threads);

struct GoldenVerdict {
    std::string name;         ///< of the case
    std::string device;       ///< the back end
    LedgerComparison ledger;  ///< exact
    ImageVerdict image;       ///< statistical
    bool ledger_waived = false;
    std::string reconstruction_fault;  ///< see PipelineImage
    MeasuredImage found, golden;
    std::vector<std::string> faults;  ///< one sentence each: what failed and is not waived
    std::vector<std::string> waived;  ///< what failed and is, with the waiver
    double seconds = 0.0;

    bool passed() const { return faults.empty(); }
};

/// Renders the case and holds it against its golden files. A waiver of a stage covers the ledger
/// from its first difference on. `false_alarm`: see GateSettings.
GoldenVerdict judge_golden(const std::filesystem::path& golden, const GoldenCase& golden_case,
                           const Backend& backend, WaiverBook& waivers, double false_alarm,
                           std::size_t threads = 0);

}  // namespace scotty::verify
