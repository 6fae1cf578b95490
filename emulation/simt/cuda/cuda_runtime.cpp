#include "emulation/simt/cuda/cuda_runtime.h"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "emulation/execution/cuda_errors.h"
#include "emulation/simt/current_device.h"

namespace scotty::emulation::simt::cuda {

struct Stream {};
struct Event {
    std::chrono::steady_clock::time_point time;
};

namespace {

/// A failed launch makes all later calls fail, until the host asks for the error.
cudaError_t status() {
    return CurrentDevice::launch_failure().empty() ? cudaSuccess : cudaErrorLaunchFailure;
}

/// Null without a checker.
MemoryChecker* current_checker() {
    const Executor* executor = CurrentDevice::current();
    return executor == nullptr ? nullptr : executor->checker();
}

/// The text of the failure that the host asked for last.
std::string& told() {
    static thread_local std::string text;
    return text;
}

}  // namespace

cudaError_t cudaGetLastError() {
    const cudaError_t error = status();
    if (error != cudaSuccess) told() = std::exchange(CurrentDevice::launch_failure(), "");
    return error;
}

const char* cudaGetErrorName(cudaError_t error) { return cuda_error(error).name; }

const char* cudaGetErrorString(cudaError_t error) {
    if (error != cudaErrorLaunchFailure) return cuda_error(error).text;
    if (status() != cudaSuccess) cudaGetLastError();
    return told().c_str();
}

cudaError_t cudaMalloc(void** memory, std::size_t bytes) {
    if (status() != cudaSuccess) return status();
    *memory = nullptr;
    if (bytes == 0) return cudaSuccess;
    if (MemoryChecker* checker = current_checker(); checker != nullptr) {
        *memory = checker->allocate(bytes);
        return *memory == nullptr ? cudaErrorMemoryAllocation : cudaSuccess;
    }
    void* host = ::operator new (bytes, std::align_val_t{256}, std::nothrow);
    if (host == nullptr) return cudaErrorMemoryAllocation;
    std::memset(host, kPoisonByte, bytes);
    *memory = host;
    return cudaSuccess;
}

cudaError_t cudaFree(void* memory) {
    MemoryChecker* checker = current_checker();
    if (checker == nullptr || !checker->release(memory)) {
        ::operator delete (memory, std::align_val_t{256});
    }
    return status();
}

cudaError_t cudaMallocHost(void** memory, std::size_t bytes) {
    *memory = ::operator new (bytes, std::align_val_t{256});
    return status();
}

cudaError_t cudaFreeHost(void* memory) {
    ::operator delete (memory, std::align_val_t{256});
    return status();
}

cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind) {
    if (status() != cudaSuccess) return status();
    if (bytes != 0 && (to == nullptr || from == nullptr)) return cudaErrorInvalidValue;
    if (bytes != 0) std::memcpy(to, from, bytes);
    if (MemoryChecker* checker = current_checker(); checker != nullptr) {
        checker->note_upload(to, bytes);
        checker->note_download(to, from, bytes);
    }
    return cudaSuccess;
}

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                            cudaStream_t) {
    return cudaMemcpy(to, from, bytes, kind);
}

cudaError_t cudaMemset(void* memory, int value, std::size_t bytes) {
    if (status() != cudaSuccess) return status();
    if (bytes != 0 && memory == nullptr) return cudaErrorInvalidValue;
    if (bytes != 0) std::memset(memory, value, bytes);
    if (MemoryChecker* checker = current_checker(); checker != nullptr) {
        checker->note_upload(memory, bytes);
    }
    return cudaSuccess;
}

cudaError_t cudaMemsetAsync(void* memory, int value, std::size_t bytes, cudaStream_t) {
    return cudaMemset(memory, value, bytes);
}

cudaError_t cudaGetDevice(int* device) {
    *device = 0;
    return status();
}

cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr, int) {
    *value = kMultiprocessors;
    return status();
}

cudaError_t cudaDeviceSynchronize() { return status(); }

cudaError_t cudaStreamCreate(cudaStream_t* stream) {
    *stream = new Stream;
    return status();
}

cudaError_t cudaStreamDestroy(cudaStream_t stream) {
    delete stream;
    return status();
}

cudaError_t cudaStreamSynchronize(cudaStream_t) { return status(); }

cudaError_t cudaEventCreate(cudaEvent_t* event) {
    *event = new Event{};
    return status();
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

cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end) {
    const std::chrono::duration<float, std::milli> elapsed = end->time - begin->time;
    *milliseconds = elapsed.count();
    return status();
}

}  // namespace scotty::emulation::simt::cuda
