/// A back end's run as a capture in the temporary folder, which goes with this object.
#pragma once

#include <filesystem>
#include <optional>

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

class TemporaryCapture {
 public:
    TemporaryCapture(const Backend& backend, const PipelineInput& input);
    ~TemporaryCapture();
    TemporaryCapture(const TemporaryCapture&) = delete;
    TemporaryCapture& operator=(const TemporaryCapture&) = delete;

    const Capture& get() const { return *capture_; }

 private:
    std::filesystem::path folder_;
    std::optional<Capture> capture_;
};

}  // namespace scotty::verify
