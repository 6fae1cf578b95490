#include <cuda_runtime.h>

#include "gpu/host/pipeline.h"

namespace scotty::gpu {

std::optional<DeviceInfo> find_device() {
    int count = 0;
    if (cudaGetDeviceCount(&count) != cudaSuccess || count == 0) {
        cudaGetLastError();
        return std::nullopt;
    }
    cudaDeviceProp properties{};
    if (cudaGetDeviceProperties(&properties, 0) != cudaSuccess) return std::nullopt;
    DeviceInfo info;
    info.name = properties.name;
    info.compute_major = properties.major;
    info.compute_minor = properties.minor;
    info.multiprocessors = properties.multiProcessorCount;
    std::size_t total = 0;
    if (cudaMemGetInfo(&info.free_bytes, &total) != cudaSuccess) cudaGetLastError();
    info.memory_bytes = properties.totalGlobalMem;
    cudaDriverGetVersion(&info.driver_version);
    cudaRuntimeGetVersion(&info.runtime_version);
    return info;
}

}  // namespace scotty::gpu
