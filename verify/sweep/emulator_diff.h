/// A back end's run held against the emulator's while it happens.
#pragma once

#include <string>
#include <vector>

#include "verify/backends/backend.h"
#include "verify/backends/temporary_capture.h"
#include "verify/capture/failure.h"
#include "verify/capture/pipeline_input.h"
#include "verify/diff/diff.h"
#include "verify/report/report.h"

namespace scotty::verify {

/// Renders with the emulator, and compares with that whatever is shown to observer().
class EmulatorDiff {
 public:
    EmulatorDiff(const PipelineInput& input, std::size_t threads, const Backend& backend);

    reference::StageObserver& observer() { return differ_; }
    const Capture& expected() const { return expected_.get(); }  ///< the emulator's run
    /// Closes the books: counts, and one failure for every stage that differs or, where the run
    /// was not cut short, is missing.
    std::vector<Failure> finish(StageCounts& counts, bool whole_run);

 private:
    TemporaryCapture expected_;
    Differ differ_;
};

}  // namespace scotty::verify
