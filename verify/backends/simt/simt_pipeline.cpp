#include "verify/backends/simt/simt_pipeline.h"

#include "emulation/check/source_line.h"
#include "emulation/device/watch.h"
#include "emulation/simt/current_device.h"
#include "gpu/host/pipeline_build.h"

namespace scotty::simt {

namespace {

using emulation::simt::CurrentDevice;
using emulation::simt::Executor;

/// gpu/'s pipeline with its executor made current for every call.
class SimtPipeline final : public gpu::Pipeline {
 public:
    SimtPipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                 const reference::PipelineParameters& parameters, const SimtOptions& options,
                 reference::StageObserver* observer, const gpu::PipelineOptions& pipeline)
        : executor_(options) {
        if (checks_memory()) executor_.check_memory();
        const CurrentDevice here(executor_);
        CurrentDevice::launch_failure().clear();
        pipeline_ = gpu::simt::make_pipeline(scene, bvh, parameters, pipeline, observer);
    }

    ~SimtPipeline() override {
        const CurrentDevice here(executor_);
        pipeline_.reset();
    }

    reference::Image render() override {
        const CurrentDevice here(executor_);
        return pipeline_->render();
    }
    void look(const reference::Camera& camera,
              const reference::PipelineParameters& parameters) override {
        pipeline_->look(camera, parameters);
    }
    void trace(std::span<const reference::Ray> rays, gpu::TraversalKind kind,
               std::span<reference::Hit> hits) override {
        const CurrentDevice here(executor_);
        pipeline_->trace(rays, kind, hits);
    }
    double time_trace(std::span<const reference::Ray> rays, gpu::TraversalKind kind,
                      int repeats) override {
        const CurrentDevice here(executor_);
        return pipeline_->time_trace(rays, kind, repeats);
    }
    std::vector<reference::OwnedBuffer> run_stage(const reference::StageView& stage) override {
        const CurrentDevice here(executor_);
        return pipeline_->run_stage(stage);
    }
    const std::vector<gpu::LaunchRecord>& launches() override { return pipeline_->launches(); }
    void clear_launches() override { pipeline_->clear_launches(); }
    std::size_t device_bytes() const override { return pipeline_->device_bytes(); }

 private:
    Executor executor_;
    std::unique_ptr<gpu::Pipeline> pipeline_;
};

#if defined(SCOTTY_CHECKED)
bool watches = true;
#else
constexpr bool watches = false;
#endif

/// Of the emulator, where the program watches that too.
const emulation::simt::MemoryChecker* volume_checker() {
#if defined(SCOTTY_VOLUME_CHECKED)
    return emulation::Watch::latest();
#else
    return nullptr;
#endif
}

}  // namespace

bool checks_memory() { return watches; }

void watch_memory([[maybe_unused]] bool on) {
#if defined(SCOTTY_CHECKED)
    watches = on;
#endif
}

std::optional<WrittenBy> written_by(const void* shown) {
    const Executor* executor = CurrentDevice::current();
    const emulation::simt::MemoryChecker* checker =
        executor != nullptr ? executor->checker() : volume_checker();
    if (checker == nullptr) return std::nullopt;
    const auto writer = checker->last_writer(shown);
    if (!writer) return std::nullopt;
    return WrittenBy{writer->kernel, writer->in_last_launch, writer->block, writer->thread,
                     emulation::simt::source_line(writer->place)};
}

std::unique_ptr<gpu::Pipeline> make_simt_pipeline(const reference::Scene& scene,
                                                  const reference::WideBvh& bvh,
                                                  const reference::PipelineParameters& parameters,
                                                  const SimtOptions& options,
                                                  reference::StageObserver* observer,
                                                  const gpu::PipelineOptions& pipeline) {
    return std::make_unique<SimtPipeline>(scene, bvh, parameters, options, observer, pipeline);
}

}  // namespace scotty::simt
