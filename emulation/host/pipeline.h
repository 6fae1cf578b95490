/// The breadth-first path tracer, kernel for kernel, on the CPU.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/pipeline_interface.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

using reference::LaunchRecord;
using reference::TraversalKind;

/// Emulates one scene under one set of parameters.
///
/// The scene and the BVH are borrowed: they outlive the pipeline. bvh.width must equal
/// parameters.width. Buffers are kept between calls and grow with the rays in flight
/// (parameters.batch_rays), not with the image.
class Pipeline final : public reference::PipelineInterface {
 public:
    Pipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
             const reference::PipelineParameters& parameters, const DeviceOptions& device = {},
             reference::StageObserver* observer = nullptr);
    ~Pipeline() override;

    reference::Image render() override;
    void look(const reference::Camera& camera,
              const reference::PipelineParameters& parameters) override;
    void trace(std::span<const reference::Ray> rays, TraversalKind kind,
               std::span<reference::Hit> hits) override;
    /// By the clock.
    double time_trace(std::span<const reference::Ray> rays, TraversalKind kind,
                      int repeats) override;
    std::vector<reference::OwnedBuffer> run_stage(const reference::StageView& stage) override;
    const std::vector<LaunchRecord>& launches() override;
    void clear_launches() override;
    std::size_t device_bytes() const override;

 private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace scotty::emulation
