/// A back end's run held against the emulator's while it happens.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "verify/diff.h"
#include "verify/failure.h"
#include "verify/pipeline_input.h"
#include "verify/report.h"

namespace scotty::verify {

/// Renders with the emulator into a capture in the temporary folder, and compares with that
/// whatever is shown to observer(). The capture goes with this object.
class EmulatorDiff {
 public:
    EmulatorDiff(const PipelineInput& input, std::size_t threads, const std::string& backend);
    ~EmulatorDiff();
    EmulatorDiff(const EmulatorDiff&) = delete;
    EmulatorDiff& operator=(const EmulatorDiff&) = delete;

    reference::StageObserver& observer() { return *differ_; }
    /// Closes the books: counts, and one failure for every stage that differs or, where the run
    /// was not cut short, is missing.
    std::vector<Failure> finish(StageCounts& counts, bool whole_run);

 private:
    std::filesystem::path folder_;
    std::optional<Capture> capture_;
    std::optional<Differ> differ_;
};

}  // namespace scotty::verify
