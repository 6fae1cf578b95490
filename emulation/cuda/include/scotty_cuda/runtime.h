/// The CUDA runtime's functions, as far as they make sense without a device
/// (docs/cuda-support.md lists them).
// NOLINTBEGIN
#pragma once

#include <stddef.h>

#include "launch.h"

enum cudaError {
    cudaSuccess = 0,
    cudaErrorInvalidValue = 1,
    cudaErrorMemoryAllocation = 2,
    cudaErrorInitializationError = 3,
    cudaErrorInvalidConfiguration = 9,
    cudaErrorInvalidPitchValue = 12,
    cudaErrorInvalidSymbol = 13,
    cudaErrorInvalidDevicePointer = 17,
    cudaErrorInvalidMemcpyDirection = 21,
    cudaErrorInvalidDeviceFunction = 98,
    cudaErrorNoDevice = 100,
    cudaErrorInvalidDevice = 101,
    cudaErrorInvalidResourceHandle = 400,
    cudaErrorNotReady = 600,
    cudaErrorIllegalAddress = 700,
    cudaErrorLaunchOutOfResources = 701,
    cudaErrorLaunchTimeout = 702,
    cudaErrorAssert = 710,
    cudaErrorLaunchFailure = 719,
    cudaErrorNotSupported = 801,
    cudaErrorUnknown = 999
};
typedef cudaError cudaError_t;
enum cudaMemcpyKind {
    cudaMemcpyHostToHost = 0,
    cudaMemcpyHostToDevice = 1,
    cudaMemcpyDeviceToHost = 2,
    cudaMemcpyDeviceToDevice = 3,
    cudaMemcpyDefault = 4
};
struct scotty_stream;
struct scotty_event;
typedef scotty_stream* cudaStream_t;
typedef scotty_event* cudaEvent_t;
typedef void (*cudaHostFn_t)(void*);
#define cudaStreamPerThread ((cudaStream_t)2)
#define cudaStreamLegacy ((cudaStream_t)1)
enum {
    cudaStreamDefault = 0,
    cudaStreamNonBlocking = 1,
    cudaEventDefault = 0,
    cudaEventBlockingSync = 1,
    cudaEventDisableTiming = 2,
    cudaHostAllocDefault = 0,
    cudaHostAllocPortable = 1,
    cudaHostAllocMapped = 2,
    cudaHostAllocWriteCombined = 4,
    cudaMemAttachGlobal = 1,
    cudaMemAttachHost = 2,
    cudaDeviceScheduleAuto = 0,
    cudaDeviceMapHost = 8,
    cudaCpuDeviceId = -1
};
enum cudaDeviceAttr {
    cudaDevAttrMaxThreadsPerBlock = 1,
    cudaDevAttrMaxSharedMemoryPerBlock = 8,
    cudaDevAttrWarpSize = 10,
    cudaDevAttrMultiProcessorCount = 16,
    cudaDevAttrComputeCapabilityMajor = 75,
    cudaDevAttrComputeCapabilityMinor = 76,
    cudaDevAttrMaxSharedMemoryPerBlockOptin = 97
};
enum cudaFuncAttribute {
    cudaFuncAttributeMaxDynamicSharedMemorySize = 8,
    cudaFuncAttributePreferredSharedMemoryCarveout = 9
};
enum cudaFuncCache {
    cudaFuncCachePreferNone,
    cudaFuncCachePreferShared,
    cudaFuncCachePreferL1,
    cudaFuncCachePreferEqual
};
enum cudaMemoryAdvise {
    cudaMemAdviseSetReadMostly = 1,
    cudaMemAdviseSetPreferredLocation = 3,
    cudaMemAdviseSetAccessedBy = 5
};
struct cudaDeviceProp {
    char name[256];
    size_t totalGlobalMem, sharedMemPerBlock, sharedMemPerMultiprocessor, sharedMemPerBlockOptin;
    size_t totalConstMem;
    int regsPerBlock, warpSize, maxThreadsPerBlock, maxThreadsDim[3], maxGridSize[3];
    int clockRate, major, minor, multiProcessorCount, maxThreadsPerMultiProcessor;
    int memoryClockRate, memoryBusWidth, l2CacheSize, concurrentKernels, managedMemory;
    int concurrentManagedAccess, unifiedAddressing, canMapHostMemory, integrated, asyncEngineCount;
    int cooperativeLaunch, ECCEnabled, computeMode, maxBlocksPerMultiProcessor;
};

#define SCOTTY_API extern "C" cudaError_t
SCOTTY_API cudaGetLastError();
SCOTTY_API cudaPeekAtLastError();
extern "C" const char* cudaGetErrorName(cudaError_t error);
extern "C" const char* cudaGetErrorString(cudaError_t error);

SCOTTY_API scotty_malloc(void** memory, size_t bytes, int kind, const void* place);
SCOTTY_API cudaFree(void* memory);
SCOTTY_API cudaFreeHost(void* memory);
SCOTTY_API cudaMemcpy(void* to, const void* from, size_t bytes, cudaMemcpyKind kind);
extern "C++" cudaError_t cudaMemcpyAsync(void* to, const void* from, size_t bytes,
                                         cudaMemcpyKind kind, cudaStream_t stream = nullptr);
SCOTTY_API cudaMemcpy2D(void* to, size_t to_pitch, const void* from, size_t from_pitch,
                        size_t width, size_t height, cudaMemcpyKind kind);
SCOTTY_API cudaMemset(void* memory, int value, size_t bytes);
extern "C++" cudaError_t cudaMemsetAsync(void* memory, int value, size_t bytes,
                                         cudaStream_t stream = nullptr);
SCOTTY_API cudaMemset2D(void* memory, size_t pitch, int value, size_t width, size_t height);
SCOTTY_API cudaMemGetInfo(size_t* free, size_t* total);
SCOTTY_API cudaHostRegister(void* memory, size_t bytes, unsigned flags);
SCOTTY_API cudaHostUnregister(void* memory);

SCOTTY_API cudaDeviceSynchronize();
SCOTTY_API cudaThreadSynchronize();
SCOTTY_API cudaDeviceReset();
SCOTTY_API cudaGetDevice(int* device);
SCOTTY_API cudaSetDevice(int device);
SCOTTY_API cudaSetDeviceFlags(unsigned flags);
SCOTTY_API cudaGetDeviceCount(int* count);
SCOTTY_API cudaGetDeviceProperties(cudaDeviceProp* properties, int device);
SCOTTY_API cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int device);
SCOTTY_API cudaDriverGetVersion(int* version);
SCOTTY_API cudaRuntimeGetVersion(int* version);

SCOTTY_API cudaStreamCreate(cudaStream_t* stream);
SCOTTY_API cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned flags);
SCOTTY_API cudaStreamCreateWithPriority(cudaStream_t* stream, unsigned flags, int priority);
SCOTTY_API cudaStreamDestroy(cudaStream_t stream);
SCOTTY_API cudaStreamSynchronize(cudaStream_t stream);
SCOTTY_API cudaStreamQuery(cudaStream_t stream);
extern "C++" cudaError_t cudaStreamWaitEvent(cudaStream_t stream, cudaEvent_t event,
                                             unsigned flags = 0);
SCOTTY_API cudaLaunchHostFunc(cudaStream_t stream, cudaHostFn_t function, void* data);
SCOTTY_API cudaEventCreate(cudaEvent_t* event);
SCOTTY_API cudaEventCreateWithFlags(cudaEvent_t* event, unsigned flags);
SCOTTY_API cudaEventDestroy(cudaEvent_t event);
extern "C++" cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream = nullptr);
SCOTTY_API cudaEventSynchronize(cudaEvent_t event);
SCOTTY_API cudaEventQuery(cudaEvent_t event);
SCOTTY_API cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end);
SCOTTY_API scotty_symbol_copy(void* symbol, size_t symbol_bytes, void* other, size_t bytes,
                              size_t offset, int to_symbol, const void* place);
#undef SCOTTY_API

template <class T>
cudaError_t cudaMalloc(T** memory, size_t bytes) {
    return scotty_malloc((void**)memory, bytes, 0, __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMallocAsync(T** memory, size_t bytes, cudaStream_t) {
    return scotty_malloc((void**)memory, bytes, 0, __builtin_return_address(0));
}
static inline cudaError_t cudaFreeAsync(void* memory, cudaStream_t) { return cudaFree(memory); }
template <class T>
cudaError_t cudaMallocHost(T** memory, size_t bytes, unsigned = 0) {
    return scotty_malloc((void**)memory, bytes, 1, __builtin_return_address(0));
}
template <class T>
cudaError_t cudaHostAlloc(T** memory, size_t bytes, unsigned) {
    return scotty_malloc((void**)memory, bytes, 1, __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMallocManaged(T** memory, size_t bytes, unsigned = 1) {
    return scotty_malloc((void**)memory, bytes, 2, __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMallocPitch(T** memory, size_t* pitch, size_t width, size_t height) {
    *pitch = (width + 511) / 512 * 512;
    return scotty_malloc((void**)memory, *pitch * height, 0, __builtin_return_address(0));
}
template <class T>
cudaError_t cudaHostGetDevicePointer(T** device, void* host, unsigned) {
    *device = (T*)host;
    return cudaSuccess;
}
template <class T>
cudaError_t cudaMemcpyToSymbol(const T& symbol, const void* from, size_t bytes, size_t offset = 0,
                               cudaMemcpyKind = cudaMemcpyHostToDevice) {
    return scotty_symbol_copy((void*)&symbol, sizeof symbol, (void*)from, bytes, offset, 1,
                              __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMemcpyFromSymbol(void* to, const T& symbol, size_t bytes, size_t offset = 0,
                                 cudaMemcpyKind = cudaMemcpyDeviceToHost) {
    return scotty_symbol_copy((void*)&symbol, sizeof symbol, to, bytes, offset, 0,
                              __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMemcpyToSymbolAsync(const T& symbol, const void* from, size_t bytes, size_t offset,
                                    cudaMemcpyKind, cudaStream_t = nullptr) {
    return scotty_symbol_copy((void*)&symbol, sizeof symbol, (void*)from, bytes, offset, 1,
                              __builtin_return_address(0));
}
template <class T>
cudaError_t cudaMemcpyFromSymbolAsync(void* to, const T& symbol, size_t bytes, size_t offset,
                                      cudaMemcpyKind, cudaStream_t = nullptr) {
    return scotty_symbol_copy((void*)&symbol, sizeof symbol, to, bytes, offset, 0,
                              __builtin_return_address(0));
}
template <class U, class T>
cudaError_t cudaGetSymbolAddress(U** address, const T& symbol) {
    *address = (U*)&symbol;
    return cudaSuccess;
}
template <class T>
cudaError_t cudaGetSymbolSize(size_t* bytes, const T& symbol) {
    *bytes = sizeof symbol;
    return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaFuncSetAttribute(Kernel, cudaFuncAttribute, int) {
    return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaFuncSetCacheConfig(Kernel, cudaFuncCache) {
    return cudaSuccess;
}
static inline cudaError_t cudaDeviceSetCacheConfig(cudaFuncCache) { return cudaSuccess; }
template <class Kernel>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, Kernel, int, size_t) {
    *blocks = 8;
    return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaOccupancyMaxPotentialBlockSize(int* grid, int* block, Kernel, size_t = 0,
                                               int limit = 0) {
    *grid = 32;
    *block = limit > 0 && limit < 256 ? limit : 256;
    return cudaSuccess;
}
template <class T>
cudaError_t cudaMemPrefetchAsync(const T*, size_t, int, cudaStream_t = nullptr) {
    return cudaSuccess;
}
template <class T>
cudaError_t cudaMemAdvise(const T*, size_t, cudaMemoryAdvise, int) {
    return cudaSuccess;
}
namespace scotty_cuda {
/// Device memory with small numbers in it, for scotty check --launch.
template <class T>
T* filled(size_t count) {
    T* host = (T*)calloc(count, sizeof(T));
    for (size_t i = 0; i < count; ++i) {
        if constexpr (std::is_arithmetic<T>::value) host[i] = (T)(i % 64);
    }
    T* memory = nullptr;
    cudaMalloc(&memory, count * sizeof(T));
    cudaMemcpy(memory, host, count * sizeof(T), cudaMemcpyHostToDevice);
    free(host);
    return memory;
}
template <class... P, size_t... I>
void launch_packed(void (*kernel)(P...), const Config& config, void** arguments,
                   std::index_sequence<I...>) {
    launcher("kernel", kernel, config)(*(std::remove_cv_t<P>*)arguments[I]...);
}
}  // namespace scotty_cuda
template <class... P>
cudaError_t cudaLaunchKernel(void (*kernel)(P...), dim3 grid, dim3 block, void** arguments,
                             size_t bytes = 0, cudaStream_t stream = nullptr) {
    scotty_cuda::launch_packed(kernel, scotty_cuda::Config(grid, block, bytes, stream), arguments,
                               std::index_sequence_for<P...>());
    return cudaPeekAtLastError();
}
// NOLINTEND
