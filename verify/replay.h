/// Captured stages run again by a back end: one alone, or each on A's inputs (an isolated diff).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "emulation/device.h"
#include "reference/owned_buffer.h"
#include "verify/capture.h"
#include "verify/diff.h"
#include "verify/pipeline_input.h"

namespace scotty::verify {

/// Something that can run a pipeline, or one of its stages alone.
struct Backend {
    std::string name;
    /// A render, shown to the observer.
    std::function<void(const PipelineInput&, reference::StageObserver&)> render;
    /// One stage; the view's inputs are as prepare_stage() makes them.
    std::function<std::vector<reference::OwnedBuffer>(const PipelineInput&,
                                                      const reference::StageView&)>
        run_stage;
};

/// By its name on the command line; throws bad_input naming those there are.
Backend backend_named(const std::string& name, const emulation::DeviceOptions& device);
const std::vector<std::string>& backend_names();

/// Runs one stage and compares with what was captured of it. Throws bad_input where there is no
/// such stage, or the capture lacks what it needs.
DiffReport replay_stage(const Capture& capture, const std::string& stage, const Backend& backend);

/// Every stage of the capture alone.
DiffReport diff_isolated(const Capture& capture, const Backend& backend, DiffOptions options);

/// A fresh run from the capture's input.
DiffReport diff_with_run(const Capture& capture, const Backend& backend, DiffOptions options);

}  // namespace scotty::verify
