/// A back end's run as a capture in the temporary folder, which goes with this object or when a
/// signal ends the program.
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
