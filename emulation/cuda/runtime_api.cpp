// The CUDA runtime's functions on the simulated device. Everything is done when a call returns.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#include "emulation/cuda/include/scotty_cuda/runtime.h"
#include "emulation/cuda/machine.h"
#include "emulation/execution/cuda_errors.h"

struct scotty_stream {};  // NOLINT
struct scotty_event {     // NOLINT
    std::chrono::steady_clock::time_point time;
};

namespace {

using namespace scotty::emulation::cuda;  // NOLINT

cudaError_t status() { return static_cast<cudaError_t>(Machine::get().error()); }

cudaError_t fail(FindingKind kind, cudaError_t code, const std::string& what, const void* place) {
    Machine::get().report_call(kind, what, place);
    Machine::get().set_error(code);
    return code;
}

/// Whether the bytes may be copied: device memory must be allocated as far as they reach.
bool fits(const void* at, std::size_t bytes, const char* call, const void* place) {
    Machine& machine = Machine::get();
    Region* const region = machine.memory().find(at);
    if (region == nullptr) {
        if (!machine.memory().in_arena(at)) return true;
        fail(FindingKind::bounds, cudaErrorInvalidValue,
             std::string(call) + " in device memory that is not allocated", place);
        return false;
    }
    if (region->freed) {
        fail(FindingKind::freed, cudaErrorInvalidValue,
             std::string(call) + " in memory that was freed", place);
        return false;
    }
    const auto first = static_cast<std::size_t>(static_cast<const std::byte*>(at) - region->begin);
    if (first + bytes > region->bytes) {
        fail(FindingKind::bounds, cudaErrorInvalidValue,
             std::string(call) + " of " + std::to_string(bytes) + " bytes from byte " +
                 std::to_string(first) + " of an allocation of " + std::to_string(region->bytes),
             place);
        return false;
    }
    return true;
}

/// Device memory, for the direction of a copy.
bool on_device(const void* at) {
    Region* const region = Machine::get().memory().find(at);
    return region != nullptr && region->kind == RegionKind::device;
}

cudaError_t copy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                 const void* place) {
    Machine& machine = Machine::get();
    if (status() != cudaSuccess) return status();
    if (bytes == 0) return cudaSuccess;
    if (to == nullptr || from == nullptr) {
        return fail(FindingKind::call, cudaErrorInvalidValue, "cudaMemcpy with a null pointer",
                    place);
    }
    const bool to_device = kind == cudaMemcpyHostToDevice || kind == cudaMemcpyDeviceToDevice;
    const bool from_device = kind == cudaMemcpyDeviceToHost || kind == cudaMemcpyDeviceToDevice;
    if (kind != cudaMemcpyDefault &&
        ((!to_device && on_device(to)) || (!from_device && on_device(from)) ||
         (to_device && machine.memory().find(to) == nullptr && !machine.memory().in_arena(to)) ||
         (from_device && machine.memory().find(from) == nullptr &&
          !machine.memory().in_arena(from)))) {
        return fail(FindingKind::call, cudaErrorInvalidValue,
                    "cudaMemcpy in a direction that is not that of its pointers", place);
    }
    if (!fits(to, bytes, "a copy", place) || !fits(from, bytes, "a copy", place)) {
        return cudaErrorInvalidValue;
    }
    std::memmove(to, from, bytes);
    Region* const target = machine.memory().find(to);
    Region* const source = machine.memory().find(from);
    if (target == nullptr || target->unwritten == nullptr) return cudaSuccess;
    machine.host_wrote(*target, to, bytes);
    if (source == nullptr || source->unwritten == nullptr) return cudaSuccess;
    // What nobody has written stays so.
    const auto first = static_cast<std::size_t>(static_cast<std::byte*>(to) - target->begin);
    const auto origin =
        static_cast<std::size_t>(static_cast<const std::byte*>(from) - source->begin);
    for (std::size_t i = 0; i < bytes; ++i) {
        if (source->is_unwritten(origin + i)) {
            target->unwritten[(first + i) / 8] |= static_cast<std::uint8_t>(1u << (first + i) % 8);
        }
    }
    return cudaSuccess;
}

cudaError_t set(void* memory, int value, std::size_t bytes, const void* place) {
    Machine& machine = Machine::get();
    if (status() != cudaSuccess) return status();
    if (bytes == 0) return cudaSuccess;
    if (machine.memory().find(memory) == nullptr && !machine.memory().in_arena(memory)) {
        return fail(FindingKind::call, cudaErrorInvalidValue,
                    "cudaMemset on memory that is not the device's", place);
    }
    if (!fits(memory, bytes, "cudaMemset", place)) return cudaErrorInvalidValue;
    std::memset(memory, value, bytes);
    machine.host_wrote(*machine.memory().find(memory), memory, bytes);
    return cudaSuccess;
}

cudaError_t release(void* memory, bool host, const void* place) {
    Machine& machine = Machine::get();
    if (memory == nullptr) return cudaSuccess;
    Region* const region = machine.memory().find(memory);
    const char* const call = host ? "cudaFreeHost" : "cudaFree";
    if (region != nullptr && region->freed) {
        return fail(FindingKind::freed, cudaErrorInvalidValue,
                    std::string(call) + " of memory that was freed before", place);
    }
    const bool fits_call =
        region != nullptr && region->begin == memory && region->leak_of_interest &&
        (host ? region->kind == RegionKind::pinned : region->kind != RegionKind::pinned);
    if (!fits_call) {
        return fail(FindingKind::call, cudaErrorInvalidValue,
                    std::string(call) + " of a pointer that no allocation has given", place);
    }
    machine.memory().release(*region, machine.offset_in_text(place));
    return status();
}

}  // namespace

#define SCOTTY_PLACE __builtin_return_address(0)

// The names are CUDA's.
// NOLINTBEGIN
cudaError_t cudaGetLastError() { return static_cast<cudaError_t>(Machine::get().take_error()); }
cudaError_t cudaPeekAtLastError() { return status(); }

const char* cudaGetErrorName(cudaError_t error) {
    return scotty::emulation::cuda_error(error).name;
}
const char* cudaGetErrorString(cudaError_t error) {
    return scotty::emulation::cuda_error(error).text;
}

cudaError_t scotty_malloc(void** memory, size_t bytes, int kind, const void* place) {
    Machine& machine = Machine::get();
    if (status() != cudaSuccess) return status();
    if (memory == nullptr) {
        return fail(FindingKind::call, cudaErrorInvalidValue, "cudaMalloc of a null pointer",
                    place);
    }
    *memory = nullptr;
    if (bytes == 0) return cudaSuccess;
    const RegionKind kinds[] = {RegionKind::device, RegionKind::pinned, RegionKind::managed};
    // What the host may write without a call counts as written.
    void* const allocated =
        machine.memory().allocate(bytes, kinds[kind], machine.offset_in_text(place), kind != 0);
    if (allocated == nullptr) {
        machine.set_error(cudaErrorMemoryAllocation);
        return cudaErrorMemoryAllocation;
    }
    machine.memory().find(allocated)->leak_of_interest = true;
    *memory = allocated;
    return cudaSuccess;
}
cudaError_t cudaFree(void* memory) { return release(memory, false, SCOTTY_PLACE); }
cudaError_t cudaFreeHost(void* memory) { return release(memory, true, SCOTTY_PLACE); }
cudaError_t cudaMemcpy(void* to, const void* from, size_t bytes, cudaMemcpyKind kind) {
    return copy(to, from, bytes, kind, SCOTTY_PLACE);
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, size_t bytes, cudaMemcpyKind kind,
                            cudaStream_t) {
    return copy(to, from, bytes, kind, SCOTTY_PLACE);
}
cudaError_t cudaMemcpy2D(void* to, size_t to_pitch, const void* from, size_t from_pitch,
                         size_t width, size_t height, cudaMemcpyKind kind) {
    for (size_t row = 0; row < height; ++row) {
        const cudaError_t error =
            copy(static_cast<char*>(to) + row * to_pitch,
                 static_cast<const char*>(from) + row * from_pitch, width, kind, SCOTTY_PLACE);
        if (error != cudaSuccess) return error;
    }
    return status();
}
cudaError_t cudaMemset(void* memory, int value, size_t bytes) {
    return set(memory, value, bytes, SCOTTY_PLACE);
}
cudaError_t cudaMemsetAsync(void* memory, int value, size_t bytes, cudaStream_t) {
    return set(memory, value, bytes, SCOTTY_PLACE);
}
cudaError_t cudaMemset2D(void* memory, size_t pitch, int value, size_t width, size_t height) {
    for (size_t row = 0; row < height; ++row) {
        const cudaError_t error =
            set(static_cast<char*>(memory) + row * pitch, value, width, SCOTTY_PLACE);
        if (error != cudaSuccess) return error;
    }
    return status();
}
cudaError_t cudaMemGetInfo(size_t* free, size_t* total) {
    *total = DeviceMemory::kBytes;
    *free = DeviceMemory::kBytes - Machine::get().memory().in_use();
    return status();
}
cudaError_t cudaHostRegister(void*, size_t, unsigned) { return status(); }
cudaError_t cudaHostUnregister(void*) { return status(); }
cudaError_t scotty_symbol_copy(void* symbol, size_t symbol_bytes, void* other, size_t bytes,
                               size_t offset, int to_symbol, const void* place) {
    if (offset + bytes > symbol_bytes) {
        return fail(FindingKind::bounds, cudaErrorInvalidValue,
                    "a copy of " + std::to_string(bytes) + " bytes from byte " +
                        std::to_string(offset) + " of a variable of " +
                        std::to_string(symbol_bytes),
                    place);
    }
    if (status() != cudaSuccess) return status();
    char* const at = static_cast<char*>(symbol) + offset;
    std::memmove(to_symbol != 0 ? at : other, to_symbol != 0 ? other : at, bytes);
    return cudaSuccess;
}

cudaError_t cudaDeviceSynchronize() { return status(); }
cudaError_t cudaThreadSynchronize() { return status(); }
cudaError_t cudaDeviceReset() {
    Machine::get().reset_error();
    return cudaSuccess;
}
cudaError_t cudaGetDevice(int* device) {
    *device = 0;
    return cudaSuccess;
}
cudaError_t cudaSetDevice(int device) { return device == 0 ? cudaSuccess : cudaErrorInvalidDevice; }
cudaError_t cudaSetDeviceFlags(unsigned) { return cudaSuccess; }
cudaError_t cudaGetDeviceCount(int* count) {
    *count = 1;
    return cudaSuccess;
}
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
    *properties = {};
    std::snprintf(properties->name, sizeof properties->name, "scotty check");
    properties->totalGlobalMem = DeviceMemory::kBytes;
    properties->sharedMemPerBlock = 48 << 10;
    properties->sharedMemPerMultiprocessor = 228 << 10;
    properties->sharedMemPerBlockOptin = 227 << 10;
    properties->totalConstMem = 64 << 10;
    properties->regsPerBlock = 65536;
    properties->warpSize = 32;
    properties->maxThreadsPerBlock = 1024;
    properties->maxThreadsDim[0] = properties->maxThreadsDim[1] = 1024;
    properties->maxThreadsDim[2] = 64;
    properties->maxGridSize[0] = 0x7fffffff;
    properties->maxGridSize[1] = properties->maxGridSize[2] = 65535;
    properties->clockRate = 1000000;
    properties->major = 8;
    properties->multiProcessorCount = 4;
    properties->maxThreadsPerMultiProcessor = 2048;
    properties->memoryClockRate = 1000000;
    properties->memoryBusWidth = 1024;
    properties->l2CacheSize = 1 << 22;
    properties->concurrentKernels = properties->managedMemory = properties->unifiedAddressing = 1;
    properties->canMapHostMemory = 1;
    properties->concurrentManagedAccess = 1;
    properties->maxBlocksPerMultiProcessor = 16;
    return cudaSuccess;
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int) {
    switch (attribute) {
        case cudaDevAttrMaxThreadsPerBlock:
            *value = 1024;
            break;
        case cudaDevAttrMaxSharedMemoryPerBlock:
            *value = 48 << 10;
            break;
        case cudaDevAttrWarpSize:
            *value = 32;
            break;
        case cudaDevAttrMultiProcessorCount:
            *value = 4;
            break;
        case cudaDevAttrComputeCapabilityMajor:
            *value = 8;
            break;
        case cudaDevAttrMaxSharedMemoryPerBlockOptin:
            *value = 227 << 10;
            break;
        default:
            *value = 0;
            break;
    }
    return cudaSuccess;
}
cudaError_t cudaDriverGetVersion(int* version) { return *version = 12000, cudaSuccess; }
cudaError_t cudaRuntimeGetVersion(int* version) { return *version = 12000, cudaSuccess; }

cudaError_t cudaStreamCreate(cudaStream_t* stream) {
    *stream = new scotty_stream;
    return status();
}
cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
    return cudaStreamCreate(stream);
}
cudaError_t cudaStreamCreateWithPriority(cudaStream_t* stream, unsigned, int) {
    return cudaStreamCreate(stream);
}
cudaError_t cudaStreamDestroy(cudaStream_t stream) {
    delete stream;
    return status();
}
cudaError_t cudaStreamSynchronize(cudaStream_t) { return status(); }
cudaError_t cudaStreamQuery(cudaStream_t) { return status(); }
cudaError_t cudaStreamWaitEvent(cudaStream_t, cudaEvent_t, unsigned) { return status(); }
cudaError_t cudaLaunchHostFunc(cudaStream_t, cudaHostFn_t function, void* data) {
    function(data);
    return status();
}
cudaError_t cudaEventCreate(cudaEvent_t* event) {
    *event = new scotty_event{};
    return status();
}
cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned) {
    return cudaEventCreate(event);
}
cudaError_t cudaEventDestroy(cudaEvent_t event) {
    delete event;
    return status();
}
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t) {
    event->time = std::chrono::steady_clock::now();
    return status();
}
cudaError_t cudaEventSynchronize(cudaEvent_t) { return status(); }
cudaError_t cudaEventQuery(cudaEvent_t) { return status(); }
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end) {
    const std::chrono::duration<float, std::milli> elapsed = end->time - begin->time;
    *milliseconds = elapsed.count();
    return status();
}
// NOLINTEND
