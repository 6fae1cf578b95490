/// Launch bookkeeping on the device: checks and event times.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gpu/host/cuda_error.h"
#include "gpu/kernels/dialect.h"
#include "reference/contract/stage_log.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Threads a block of the kernels that take one item (ray, pixel) a thread.
constexpr std::uint32_t kItemThreads = 256;
inline std::uint32_t item_blocks(std::size_t items) {
    return static_cast<std::uint32_t>((items + kItemThreads - 1) / kItemThreads);
}

class LaunchLog : public reference::StageLog {
 public:
    LaunchLog(reference::StageObserver* observer, bool timings)
        : StageLog(observer), timings_(timings) {}
    ~LaunchLog() {
        for (const Pending& launch : pending_) {
            cudaEventDestroy(launch.begin);
            cudaEventDestroy(launch.end);
        }
    }
    LaunchLog(const LaunchLog&) = delete;
    LaunchLog& operator=(const LaunchLog&) = delete;

    /// Launches, checks, and notes one kernel. With an observer attached, waits for it.
    template <class Launch>
    void run(reference::StageKind kind, const reference::StagePlace& place, std::uint32_t blocks,
             std::uint64_t items, cudaStream_t stream, Launch&& launch) {
        Pending times{};
        const bool timed = timings_ && keeps_records_;
        if (timed) {
            check(cudaEventCreate(&times.begin), "creating an event");
            check(cudaEventCreate(&times.end), "creating an event");
            check(cudaEventRecord(times.begin, stream), "recording an event");
        }
        launch();
        if (const cudaError_t status = cudaGetLastError(); status != cudaSuccess) {
            check(status, "launching " + place.name(kind));
        }
        if (timed) {
            check(cudaEventRecord(times.end, stream), "recording an event");
            times.record = records_.size();
            pending_.push_back(times);
        }
        if (keeps_records_) note(kind, place, blocks, items, 0.0);
        if (observed() || wants(kind)) {
            check(cudaStreamSynchronize(stream), "running " + place.name(kind));
        }
    }

    /// Fills in the times of all launches so far; waits for the device.
    void resolve_times() {
        for (const Pending& launch : pending_) {
            float milliseconds = 0.0f;
            check(cudaEventSynchronize(launch.end), "waiting for a launch");
            check(cudaEventElapsedTime(&milliseconds, launch.begin, launch.end), "timing");
            records_[launch.record].seconds = 1e-3 * static_cast<double>(milliseconds);
            cudaEventDestroy(launch.begin);
            cudaEventDestroy(launch.end);
        }
        pending_.clear();
    }

    /// While off, launches are checked but not noted (inside repeated measurements).
    void keep_records(bool keep) { keeps_records_ = keep; }

 private:
    struct Pending {
        cudaEvent_t begin;
        cudaEvent_t end;
        std::size_t record;
    };
    bool timings_;
    bool keeps_records_ = true;
    std::vector<Pending> pending_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
