/// Who can run the pipeline: one interface for the emulator, CUDA and whoever comes next.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/image.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

/// Something that can run a pipeline, or one of its stages alone.
struct Backend {
    std::string name;
    bool has_fast_arithmetic = false;
    /// A render; shown to the observer where there is one.
    std::function<reference::Image(const PipelineInput&, reference::StageObserver*)> render;
    /// Rays from elsewhere: one hit a ray.
    std::function<void(const PipelineInput&, std::span<const reference::Ray>,
                       reference::TraversalKind, std::span<reference::Hit>)>
        trace;
    /// One stage; the view's inputs are as prepare_stage() makes them.
    std::function<std::vector<reference::OwnedBuffer>(const PipelineInput&,
                                                      const reference::StageView&)>
        run_stage;
    /// Who wrote the value at an address in a buffer that the observer, which asks, is being shown:
    /// "thread 3 of block 7 of kernel K at FILE:LINE"; empty where that is not known.
    std::function<std::string(const void*)> written_by = [](const void*) { return std::string(); };
};

/// By its name on the command line. Throws bad_input naming those there are, and
/// missing_environment where this machine or this build cannot serve it. `device`: threads of the
/// CPU and the order of blocks (and, in simt, of threads), where the CPU is what runs.
Backend backend_named(const std::string& name, const emulation::DeviceOptions& device);
inline Backend backend_named(const std::string& name, std::size_t threads) {
    return backend_named(name, emulation::DeviceOptions{.threads = threads});
}

/// Every name, "emulator" first, whether this machine can serve it or not.
const std::vector<std::string>& backend_names();

/// Throws bad_input where the parameters ask for arithmetic that the back end does not have.
void expect_arithmetic(const Backend& backend, const reference::PipelineParameters& parameters);

}  // namespace scotty::verify
