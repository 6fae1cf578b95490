/// Device memory that frees itself; grows, never shrinks, and is not initialised.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu/host/cuda_error.h"
#include "gpu/kernels/dialect.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Counts bytes against an optional limit, so that running out can be tried on any device.
struct MemoryBudget {
    std::size_t limit = 0;  ///< 0: what the device has
    std::size_t used = 0;
};

template <class T>
class DeviceMemory {
 public:
    explicit DeviceMemory(MemoryBudget& budget) : budget_(&budget) {}
    ~DeviceMemory() { release(); }
    DeviceMemory(const DeviceMemory&) = delete;
    DeviceMemory& operator=(const DeviceMemory&) = delete;
    friend void swap(DeviceMemory& a, DeviceMemory& b) noexcept {
        std::swap(a.budget_, b.budget_);
        std::swap(a.memory_, b.memory_);
        std::swap(a.count_, b.count_);
        std::swap(a.capacity_, b.capacity_);
    }

    /// At least `count` elements; the content is lost when it has to grow.
    void resize(std::size_t count, const char* name) {
        count_ = count;
        if (count <= capacity_) return;
        release();
        const std::size_t bytes = count * sizeof(T);
        const std::string what =
            std::string("allocating ") + std::to_string(bytes) + " bytes for " + name;
        if (budget_->limit != 0 && budget_->used + bytes > budget_->limit) {
            throw OutOfDeviceMemory(what + ": over the limit of " + std::to_string(budget_->limit) +
                                    " bytes");
        }
        check(cudaMalloc(reinterpret_cast<void**>(&memory_), bytes), what);
        label_memory(memory_, name);
        capacity_ = count;
        budget_->used += bytes;
    }
    void upload(std::span<const T> host, const char* name) {
        resize(host.size(), name);
        if (host.empty()) return;
        check(cudaMemcpy(memory_, host.data(), host.size_bytes(), cudaMemcpyHostToDevice), name);
    }
    void fill_bytes(int byte) {
        if (count_ == 0) return;
        check(cudaMemset(memory_, byte, count_ * sizeof(T)), "filling device memory");
    }
    void release() {
        if (memory_ != nullptr) cudaFree(memory_);
        budget_->used -= capacity_ * sizeof(T);
        memory_ = nullptr;
        capacity_ = 0;
    }

    T* data() const { return memory_; }
    std::size_t size() const { return count_; }

 private:
    MemoryBudget* budget_;
    T* memory_ = nullptr;
    std::size_t count_ = 0;
    std::size_t capacity_ = 0;
};

/// Into the middle of an array.
template <class T>
void upload_to(T* device, std::span<const T> host, const char* name) {
    if (host.empty()) return;
    check(cudaMemcpy(device, host.data(), host.size_bytes(), cudaMemcpyHostToDevice), name);
}

template <class T>
std::vector<T> download(const T* device, std::size_t count, const char* name) {
    std::vector<T> host(count);
    check(cudaMemcpy(host.data(), device, count * sizeof(T), cudaMemcpyDeviceToHost), name);
    return host;
}

/// Host memory that the device copies to on its own, while both do something else. It is kept, as
/// such memory is slow to get.
template <class T>
class PinnedMemory {
 public:
    PinnedMemory() = default;
    ~PinnedMemory() { cudaFreeHost(memory_); }
    PinnedMemory(const PinnedMemory&) = delete;
    PinnedMemory& operator=(const PinnedMemory&) = delete;

    /// At least `count` elements; the content is lost when it has to grow.
    T* resize(std::size_t count, const char* name) {
        if (count <= capacity_) return memory_;
        cudaFreeHost(memory_);
        memory_ = nullptr;
        capacity_ = 0;
        check(cudaMallocHost(reinterpret_cast<void**>(&memory_), count * sizeof(T)), name);
        capacity_ = count;
        return memory_;
    }
    /// What is in the span after the stream's work until now.
    std::span<const T> start_download(const T* device, std::size_t count, cudaStream_t stream,
                                      const char* name) {
        T* const memory = resize(count, name);
        if (count == 0) return {};
        check(cudaMemcpyAsync(memory, device, count * sizeof(T), cudaMemcpyDeviceToHost, stream),
              name);
        return {memory, count};
    }

 private:
    T* memory_ = nullptr;
    std::size_t capacity_ = 0;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
