/// The breadth-first path tracer on a CUDA device; the emulator's interface, for plain C++ callers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/image.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::gpu {

using reference::LaunchRecord;
using reference::TraversalKind;

struct DeviceInfo {
    std::string name;
    int compute_major = 0;
    int compute_minor = 0;
    int multiprocessors = 0;
    std::size_t memory_bytes = 0;
    int driver_version = 0;
    int runtime_version = 0;
};

/// Nothing where there is no driver or no device.
std::optional<DeviceInfo> find_device();

struct PipelineOptions {
    bool timings = false;          ///< time every launch with events (LaunchRecord::seconds)
    std::size_t memory_limit = 0;  ///< bytes of device memory to stay within; 0: what there is
};

/// The pipeline on one device.
class Pipeline {
 public:
    Pipeline() = default;
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;
    virtual ~Pipeline() = default;

    virtual reference::Image render() = 0;

    /// As emulation::Pipeline::trace.
    virtual void trace(std::span<const reference::Ray> rays, TraversalKind kind,
                       std::span<reference::Hit> hits) = 0;

    /// Median seconds on the device (events) of one traversal and merge of `rays`, which must fit
    /// one batch; after two warm-up rounds. Copies are not counted.
    virtual double time_trace(std::span<const reference::Ray> rays, TraversalKind kind,
                              int repeats) = 0;

    /// What has been launched so far; waits for the device where launches are timed.
    virtual const std::vector<LaunchRecord>& launches() = 0;
    virtual void clear_launches() = 0;
    virtual std::size_t device_bytes() const = 0;
};

/// Scene and BVH are copied to the device. bvh.width == parameters.width. The kernels are those of
/// parameters.arithmetic.
///
/// Throws missing_environment without a device; when device memory runs out, batches are halved
/// and the render starts again, with the same bits.
std::unique_ptr<Pipeline> make_pipeline(const reference::Scene& scene,
                                        const reference::WideBvh& bvh,
                                        const reference::PipelineParameters& parameters,
                                        const PipelineOptions& options = {},
                                        reference::StageObserver* observer = nullptr);

/// One stage alone, on the device: as emulation::run_stage, of which it is the twin.
std::vector<reference::OwnedBuffer> run_stage(const reference::Scene& scene,
                                              const reference::WideBvh& bvh,
                                              const reference::PipelineParameters& parameters,
                                              const reference::StageView& stage);

}  // namespace scotty::gpu
