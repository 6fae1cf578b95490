/// A back end's run as a capture in memory, with its input and what is too large in the temporary
/// folder. Both go with this object, the folder also when a signal ends the program.
#pragma once

#include <optional>

#include "verify/backends/backend.h"
#include "verify/base/scratch_folder.h"
#include "verify/capture/capture.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

class TemporaryCapture {
 public:
    TemporaryCapture(const Backend& backend, const PipelineInput& input);

    const Capture& get() const { return *capture_; }

 private:
    ScratchFolder folder_;
    std::optional<Capture> capture_;
};

}  // namespace scotty::verify
