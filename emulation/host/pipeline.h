/// The breadth-first path tracer, kernel for kernel, on the CPU.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/image.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

using reference::LaunchRecord;
using reference::TraversalKind;

/// Emulates one scene under one set of parameters.
///
/// The scene and the BVH are borrowed: they outlive the pipeline. bvh.width must equal
/// parameters.width. Buffers are kept between calls and grow with the rays in flight
/// (parameters.batch_rays), not with the image.
class Pipeline {
 public:
    Pipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
             const reference::PipelineParameters& parameters, const DeviceOptions& device = {},
             reference::StageObserver* observer = nullptr);
    ~Pipeline();

    /// The image, before filters unless parameters.filter asks for one.
    reference::Image render();

    /// Traces rays that came from elsewhere. One hit per ray; for TraversalKind::any only
    /// is_hit() is meaningful under an early-out. Throws bad_input naming the ray for NaN,
    /// infinite origins or directions, a zero direction and t_min < 0.
    void trace(std::span<const reference::Ray> rays, TraversalKind kind,
               std::span<reference::Hit> hits);

    /// Launches since construction (or the last clear), in order.
    const std::vector<LaunchRecord>& launches() const;
    void clear_launches();

    /// Bytes held in device buffers now (rays, queues, hits, path state).
    std::size_t device_bytes() const;

 private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace scotty::emulation
