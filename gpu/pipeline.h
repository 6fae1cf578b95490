/// The breadth-first path tracer on a CUDA device; the emulator's interface, for plain C++ callers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reference/image.h"
#include "reference/launch_record.h"
#include "reference/pipeline_parameters.h"
#include "reference/scene.h"
#include "reference/stage_observer.h"
#include "reference/wide_bvh.h"

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

/// Scene and BVH are copied to the device at construction. bvh.width == parameters.width.
/// Throws missing_environment without a device; when device memory runs out, batches are halved
/// and the render starts again, with the same bits.
class Pipeline {
 public:
    Pipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
             const reference::PipelineParameters& parameters, const PipelineOptions& options = {},
             reference::StageObserver* observer = nullptr);
    ~Pipeline();

    reference::Image render();

    /// As emulation::Pipeline::trace.
    void trace(std::span<const reference::Ray> rays, TraversalKind kind,
               std::span<reference::Hit> hits);

    /// Median seconds on the device (events) of one traversal and merge of `rays`, which must fit
    /// one batch; after two warm-up rounds. Copies are not counted.
    double time_trace(std::span<const reference::Ray> rays, TraversalKind kind, int repeats);

    const std::vector<LaunchRecord>& launches() const;
    void clear_launches();
    std::size_t device_bytes() const;

 private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace scotty::gpu
