/// The breadth-first path tracer on a CUDA device, for plain C++ callers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "reference/contract/pipeline_interface.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::gpu {

using reference::LaunchRecord;
using Pipeline = reference::PipelineInterface;
using reference::TraversalKind;

struct DeviceInfo {
    std::string name;
    int compute_major = 0;
    int compute_minor = 0;
    int multiprocessors = 0;
    std::size_t memory_bytes = 0;
    std::size_t free_bytes = 0;  ///< of it, as this was asked for
    int driver_version = 0;
    int runtime_version = 0;
};

/// Nothing where there is no driver or no device.
std::optional<DeviceInfo> find_device();

struct PipelineOptions {
    bool timings = false;          ///< time every launch with events (LaunchRecord::seconds)
    std::size_t memory_limit = 0;  ///< bytes of device memory to stay within; 0: what there is
    /// Copies from host memory to host memory; null: memcpy. One thread takes longer for a picture
    /// than the device for its way to the host.
    void (*copy)(void* to, const void* from, std::size_t bytes) = nullptr;
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

}  // namespace scotty::gpu
