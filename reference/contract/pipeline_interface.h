/// The one interface of everything that renders: the emulator, the CUDA text on the CPU, the
/// device.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "reference/base/error.h"
#include "reference/contract/image.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"

namespace scotty::reference {

/// The pipeline for one scene, one BVH and one set of parameters, which it was made for. What it
/// borrows of them outlives it. Buffers are kept between calls.
class PipelineInterface {
 public:
    PipelineInterface() = default;
    PipelineInterface(const PipelineInterface&) = delete;
    PipelineInterface& operator=(const PipelineInterface&) = delete;
    virtual ~PipelineInterface() = default;

    /// The image; filtered where parameters.filter asks for it.
    virtual Image render() = 0;

    /// Later renders are of this camera and these parameters; scene, tree and buffers stay where
    /// they are. What a tree or a kernel was chosen by must be as it was made: the groups tree,
    /// pipeline (without batch_rays and samples_per_pass) and arithmetic. Throws bad_input where
    /// the parameters are not valid, and where the pipeline cannot change its view.
    virtual void look(const Camera& camera, const PipelineParameters& parameters) = 0;

    /// Traces rays that came from elsewhere: one hit per ray. For TraversalKind::any under an
    /// early-out only is_hit() is meaningful. Throws bad_input naming the ray for NaN, infinite
    /// origins or directions, a zero direction and t_min < 0.
    virtual void trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) = 0;

    /// Median seconds of one traversal and merge of `rays`, which must fit one batch, after two
    /// warm-up rounds; on a device by its events, without copies.
    virtual double time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) = 0;

    /// One stage alone, by the launch that a render makes too: inputs by name are read from the
    /// view (prepare_stage() makes them complete), outputs are handed back, with what the stage
    /// lowers besides. Throws bad_input naming stage and buffer for inputs that are missing or
    /// would index out of bounds.
    virtual std::vector<OwnedBuffer> run_stage(const StageView& stage) = 0;

    /// Launches since construction or the last clear, in order; waits for a device that times them.
    virtual const std::vector<LaunchRecord>& launches() = 0;
    virtual void clear_launches() = 0;

    /// Bytes held in device buffers now (rays, queues, hits, path state).
    virtual std::size_t device_bytes() const = 0;
};

}  // namespace scotty::reference
