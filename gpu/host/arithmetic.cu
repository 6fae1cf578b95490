/// Which build of the kernels serves a set of parameters.
#include "gpu/host/pipeline_build.h"

namespace scotty::gpu::fast {

MakePipeline make_pipeline;

}  // namespace scotty::gpu::fast

namespace scotty::gpu {

namespace {

bool is_fast(const reference::PipelineParameters& parameters) {
    return parameters.arithmetic == reference::Arithmetic::fast;
}

void expect_device() {
    if (find_device()) return;
    throw reference::Error::missing_environment(
        "no CUDA device: the driver is not there or shows no device (see scotty doctor)");
}

}  // namespace

std::unique_ptr<Pipeline> make_pipeline(const reference::Scene& scene,
                                        const reference::WideBvh& bvh,
                                        const reference::PipelineParameters& parameters,
                                        const PipelineOptions& options,
                                        reference::StageObserver* observer) {
    expect_device();
    return is_fast(parameters) ? fast::make_pipeline(scene, bvh, parameters, options, observer)
                               : exact::make_pipeline(scene, bvh, parameters, options, observer);
}

}  // namespace scotty::gpu
