#include "verify/backends/backend.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "emulation/host/pipeline.h"
#include "reference/base/error.h"
#include "reference/truth/embree_renderer.h"
#include "reference/truth/tracers.h"
#include "verify/backends/cuda/cuda_backend.h"
#include "verify/backends/simt/simt_pipeline.h"

namespace scotty::verify {

using reference::Error;
using reference::PipelineParameters;
using reference::Scene;
using reference::WideBvh;

namespace {

std::string written_by(const void* shown) {
    const auto writer = scotty::simt::written_by(shown);
    if (!writer) return {};
    return fmt::format("thread {} of block {} of kernel {} at {}{}", writer->thread, writer->block,
                       writer->kernel, writer->line,
                       writer->in_this_launch ? "" : ", in an earlier launch");
}

class RenderOnly final : public reference::PipelineInterface {
 public:
    RenderOnly(std::string name, RenderFunction render, const Scene& scene, const WideBvh& bvh,
               const PipelineParameters& parameters, reference::StageObserver* observer)
        : name_(std::move(name)),
          render_(std::move(render)),
          scene_(&scene),
          bvh_(bvh),
          parameters_(parameters),
          observer_(observer) {}

    reference::Image render() override { return render_(*scene_, bvh_, parameters_, observer_); }
    void look(const reference::Camera& camera, const PipelineParameters& parameters) override {
        validate(parameters);
        if (!seen_) seen_ = *scene_;
        seen_->camera = camera;
        scene_ = &*seen_;
        parameters_ = parameters;
    }
    void trace(std::span<const reference::Ray> /*rays*/, reference::TraversalKind /*kind*/,
               std::span<reference::Hit> /*hits*/) override {
        refuse();
    }
    double time_trace(std::span<const reference::Ray> /*rays*/, reference::TraversalKind /*kind*/,
                      int /*repeats*/) override {
        refuse();
    }
    std::vector<reference::OwnedBuffer> run_stage(const reference::StageView& /*stage*/) override {
        refuse();
    }
    const std::vector<reference::LaunchRecord>& launches() override { return launches_; }
    void clear_launches() override {}
    std::size_t device_bytes() const override { return 0; }

 private:
    [[noreturn]] void refuse() const {
        throw Error::bad_input("--backend " + name_, "it renders pictures only: it has no stages");
    }

    std::string name_;
    RenderFunction render_;
    const Scene* scene_;
    std::optional<Scene> seen_;  ///< the same from another camera
    const WideBvh& bvh_;
    PipelineParameters parameters_;
    reference::StageObserver* observer_;
    std::vector<reference::LaunchRecord> launches_;
};

/// Exact whatever the parameters say: what fast arithmetic is held against.
Backend emulator(const emulation::DeviceOptions& device) {
    Backend backend;
    backend.name = "emulator";
    backend.make = [device](const Scene& scene, const WideBvh& bvh, const PipelineParameters& p,
                            const PipelineMaking& making) {
        return std::make_unique<emulation::Pipeline>(scene, bvh, p, device, making.observer);
    };
    backend.written_by = written_by;
    return backend;
}

/// The CUDA pipeline's text on the CPU.
Backend simt(const scotty::simt::SimtOptions& options) {
    Backend backend;
    backend.name = "simt";
    backend.make = [options](const Scene& scene, const WideBvh& bvh, const PipelineParameters& p,
                             const PipelineMaking& making) {
        return scotty::simt::make_simt_pipeline(scene, bvh, p, options, making.observer,
                                                {.timings = making.timed});
    };
    backend.written_by = written_by;
    return backend;
}

}  // namespace

Backend render_only(std::string name, RenderFunction render) {
    Backend backend;
    backend.name = std::move(name);
    backend.make =
        [name = backend.name, render = std::move(render)](
            const Scene& scene, const WideBvh& bvh, const PipelineParameters& p,
            const PipelineMaking& making) -> std::unique_ptr<reference::PipelineInterface> {
        return std::make_unique<RenderOnly>(name, render, scene, bvh, p, making.observer);
    };
    return backend;
}

const std::vector<std::string>& backend_names() {
    static const std::vector<std::string> names{"emulator", "simt", "cuda"};
    return names;
}

Backend embree_backend(std::size_t threads) {
    Backend backend;
    backend.name = "embree";
    backend.make = [threads](const Scene& scene, const WideBvh& bvh, const PipelineParameters& p,
                             const PipelineMaking& making) {
        const auto tracer = std::make_shared<const reference::EmbreeTracer>(scene);
        const auto render = [threads, tracer](const Scene& seen, const WideBvh& /*bvh*/,
                                              const PipelineParameters& parameters,
                                              reference::StageObserver* observer) {
            return render_with_embree(seen, parameters, *tracer, threads, observer);
        };
        return std::make_unique<RenderOnly>("embree", render, scene, bvh, p, making.observer);
    };
    return backend;
}

Backend backend_named(const std::string& name, const emulation::DeviceOptions& device) {
    if (name == "emulator") return emulator(device);
    if (name == "simt") return simt(device);
    if (name == "cuda") return cuda_backend();
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
