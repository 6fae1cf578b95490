/// The calls of the CUDA runtime that gpu/ makes, on host memory, for the SIMT executor.
///
/// The include path of one target finds it instead of CUDA's. It has a namespace of its own, so
/// that one program can also hold CUDA's runtime. Streams are in order and synchronous; cudaMalloc
/// fills with kPoisonByte, so that reads of unwritten memory show.
#pragma once

#include <cstddef>

namespace scotty::emulation::simt::cuda {

enum cudaError_t {
    cudaSuccess = 0,
    cudaErrorInvalidValue = 1,
    cudaErrorMemoryAllocation = 2,
    cudaErrorLaunchFailure = 719
};
enum cudaMemcpyKind {
    cudaMemcpyHostToHost,
    cudaMemcpyHostToDevice,
    cudaMemcpyDeviceToHost,
    cudaMemcpyDeviceToDevice
};
enum cudaDeviceAttr { cudaDevAttrMultiProcessorCount = 16 };

struct Stream;
struct Event;
using cudaStream_t = Stream*;
using cudaEvent_t = Event*;

/// What the simulated device holds at once: few enough that each block takes several logical
/// blocks, as on a device.
constexpr int kMultiprocessors = 4;
constexpr int kBlocksAMultiprocessor = 8;

/// Clears the error, as CUDA does unless the error is sticky.
cudaError_t cudaGetLastError();
const char* cudaGetErrorName(cudaError_t error);
/// For a failed launch, returns the executor's message, which names kernel, block and threads.
const char* cudaGetErrorString(cudaError_t error);

cudaError_t cudaMalloc(void** memory, std::size_t bytes);
cudaError_t cudaFree(void* memory);
cudaError_t cudaMallocHost(void** memory, std::size_t bytes);
cudaError_t cudaFreeHost(void* memory);
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind);
cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                            cudaStream_t stream = nullptr);
cudaError_t cudaMemset(void* memory, int value, std::size_t bytes);
cudaError_t cudaMemsetAsync(void* memory, int value, std::size_t bytes,
                            cudaStream_t stream = nullptr);

cudaError_t cudaGetDevice(int* device);
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int device);
cudaError_t cudaDeviceSynchronize();

cudaError_t cudaStreamCreate(cudaStream_t* stream);
cudaError_t cudaStreamDestroy(cudaStream_t stream);
cudaError_t cudaStreamSynchronize(cudaStream_t stream);

cudaError_t cudaEventCreate(cudaEvent_t* event);
cudaError_t cudaEventDestroy(cudaEvent_t event);
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream = nullptr);
cudaError_t cudaEventSynchronize(cudaEvent_t event);
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end);

template <class Kernel>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, Kernel, int /*threads*/,
                                                          std::size_t /*shared_bytes*/) {
    *blocks = kBlocksAMultiprocessor;
    return cudaSuccess;
}

}  // namespace scotty::emulation::simt::cuda

using namespace scotty::emulation::simt::cuda;  // NOLINT: the names are CUDA's, which are global
