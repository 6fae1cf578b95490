#include "verify/backends/backend.h"

#include <fmt/format.h>

#include "emulation/host/pipeline.h"
#include "emulation/host/replay.h"
#include "reference/base/error.h"
#include "verify/backends/simt/simt_pipeline.h"
#if defined(SCOTTY_HAS_CUDA)
#include "gpu/host/pipeline.h"
#endif

namespace scotty::verify {

using reference::Error;
using reference::StageView;
using scotty::simt::make_simt_pipeline;
using scotty::simt::run_simt_stage;

namespace {

std::string written_by(const void* shown) {
    const auto writer = scotty::simt::written_by(shown);
    if (!writer) return {};
    return fmt::format("thread {} of block {} of kernel {} at {}{}", writer->thread, writer->block,
                       writer->kernel, writer->line,
                       writer->in_this_launch ? "" : ", in an earlier launch");
}

/// Exact whatever the parameters say: what fast arithmetic is held against.
Backend emulator(const emulation::DeviceOptions& device) {
    Backend backend;
    backend.name = "emulator";
    backend.render = [device](const PipelineInput& input, reference::StageObserver* observer) {
        return emulation::Pipeline(input.scene, input.bvh, input.parameters, device, observer)
            .render();
    };
    backend.trace = [device](const PipelineInput& input, std::span<const reference::Ray> rays,
                             reference::TraversalKind kind, std::span<reference::Hit> hits) {
        emulation::Pipeline(input.scene, input.bvh, input.parameters, device)
            .trace(rays, kind, hits);
    };
    backend.run_stage = [device](const PipelineInput& input, const StageView& stage) {
        return emulation::run_stage(input.scene, input.bvh, input.parameters, device, stage);
    };
    backend.written_by = written_by;
    return backend;
}

/// The CUDA pipeline's text on the CPU.
Backend simt(const scotty::simt::SimtOptions& options) {
    Backend backend;
    backend.name = "simt";
    backend.render = [options](const PipelineInput& input, reference::StageObserver* observer) {
        return make_simt_pipeline(input.scene, input.bvh, input.parameters, options, observer)
            ->render();
    };
    backend.trace = [options](const PipelineInput& input, std::span<const reference::Ray> rays,
                              reference::TraversalKind kind, std::span<reference::Hit> hits) {
        make_simt_pipeline(input.scene, input.bvh, input.parameters, options)
            ->trace(rays, kind, hits);
    };
    backend.run_stage = [options](const PipelineInput& input, const StageView& stage) {
        return run_simt_stage(input.scene, input.bvh, input.parameters, stage, options);
    };
    backend.written_by = written_by;
    return backend;
}

#if defined(SCOTTY_HAS_CUDA)

Backend cuda() {
    if (!gpu::find_device()) {
        throw Error::missing_environment(
            "back end cuda: no CUDA device on this machine (scotty doctor says what there is)");
    }
    Backend backend;
    backend.name = "cuda";
    backend.has_fast_arithmetic = true;
    backend.render = [](const PipelineInput& input, reference::StageObserver* observer) {
        return gpu::make_pipeline(input.scene, input.bvh, input.parameters, {}, observer)->render();
    };
    backend.trace = [](const PipelineInput& input, std::span<const reference::Ray> rays,
                       reference::TraversalKind kind, std::span<reference::Hit> hits) {
        gpu::make_pipeline(input.scene, input.bvh, input.parameters)->trace(rays, kind, hits);
    };
    backend.run_stage = [](const PipelineInput& input, const StageView& stage) {
        return gpu::run_stage(input.scene, input.bvh, input.parameters, stage);
    };
    return backend;
}

#else

Backend cuda() {
    throw Error::missing_environment(
        "back end cuda: this scotty was built where there was no CUDA compiler; build it again "
        "where nvcc is, or capture on the other machine with scotty-gpu (docs/gpu.md)");
}

#endif

}  // namespace

const std::vector<std::string>& backend_names() {
    static const std::vector<std::string> names{"emulator", "simt", "cuda"};
    return names;
}

Backend backend_named(const std::string& name, const emulation::DeviceOptions& device) {
    if (name == "emulator") return emulator(device);
    if (name == "simt") return simt(device);
    if (name == "cuda") return cuda();
    throw Error::bad_input("--backend", fmt::format("expected one of {}, found '{}'",
                                                    fmt::join(backend_names(), ", "), name));
}

void expect_arithmetic(const Backend& backend, const reference::PipelineParameters& parameters) {
    if (parameters.arithmetic == reference::Arithmetic::exact || backend.has_fast_arithmetic) {
        return;
    }
    throw Error::bad_input(
        "--arithmetic",
        fmt::format("the {} computes exactly; fast arithmetic needs --backend cuda", backend.name));
}

}  // namespace scotty::verify
