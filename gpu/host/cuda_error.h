/// Every CUDA call and launch is checked; the message names the call, the launch and the level.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "gpu/kernels/dialect.h"
#include "reference/base/error.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Thrown when device memory runs out: the pipeline answers with smaller batches.
class OutOfDeviceMemory : public reference::Error {
 public:
    explicit OutOfDeviceMemory(const std::string& what)
        : Error(reference::ErrorKind::missing_environment, what) {}
};

inline void check(cudaError_t status, const std::string& what) {
    if (status == cudaSuccess) return;
    const std::string message =
        what + ": " + cudaGetErrorName(status) + " (" + cudaGetErrorString(status) + ")";
    if (status == cudaErrorMemoryAllocation) {
        cudaGetLastError();  // this one is not sticky
        throw OutOfDeviceMemory(message);
    }
    throw reference::Error::internal(message);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
