/// The breadth-first path tracer, kernel for kernel, on the CPU.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "emulation/device.h"
#include "reference/image.h"
#include "reference/pipeline_parameters.h"
#include "reference/scene.h"
#include "reference/stage_observer.h"
#include "reference/wide_bvh.h"

namespace scotty::emulation {

/// One kernel launch as it was run: what `scotty bench` adds up.
struct LaunchRecord {
    reference::StageKind kind = reference::StageKind::primary_rays;
    std::uint32_t batch = 0;
    std::uint32_t bounce = reference::kNotApplicable;
    std::uint32_t light = reference::kNotApplicable;
    std::uint32_t level = reference::kNotApplicable;
    std::uint32_t blocks = 0;
    std::uint64_t items = 0;  ///< threads with work: rays, or queue entries of a level
    double seconds = 0.0;
};

enum class TraversalKind { closest, any };

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
