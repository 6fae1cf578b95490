/// Who can run the pipeline: one interface for the emulator, CUDA and whoever comes next.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/pipeline_interface.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

/// What a pipeline is made with besides its input.
struct PipelineMaking {
    reference::StageObserver* observer = nullptr;
    bool timed = false;  ///< launches carry their seconds (the emulator's always do)
};

/// Who can run a pipeline: a name, what it can do, and a factory.
struct Backend {
    std::string name;
    bool has_fast_arithmetic = false;
    std::size_t free_memory = 0;  ///< bytes, of a device that has its own
    /// The pipeline for an input, which is borrowed and outlives it.
    std::function<std::unique_ptr<reference::PipelineInterface>(
        const reference::Scene&, const reference::WideBvh&, const reference::PipelineParameters&,
        const PipelineMaking&)>
        make;
    /// Who wrote the value at an address in a buffer that the observer, which asks, is being shown:
    /// "thread 3 of block 7 of kernel K at FILE:LINE"; empty where that is not known.
    std::function<std::string(const void*)> written_by = [](const void*) { return std::string(); };

    std::unique_ptr<reference::PipelineInterface> pipeline(
        const PipelineInput& input, reference::StageObserver* observer = nullptr) const {
        return make(input.scene, input.bvh, input.parameters, {.observer = observer});
    }
    /// One render; shown to the observer where there is one.
    reference::Image render(const PipelineInput& input, reference::StageObserver* observer) const {
        return pipeline(input, observer)->render();
    }
};

/// A back end that renders and can do nothing else: its pipelines have no stages.
using RenderFunction = std::function<reference::Image(
    const reference::Scene&, const reference::WideBvh&, const reference::PipelineParameters&,
    reference::StageObserver*)>;
Backend render_only(std::string name, RenderFunction render);

/// Embree's paths (reference/truth/embree_renderer.h), for pictures only. `threads` 0: all.
Backend embree_backend(std::size_t threads);

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
