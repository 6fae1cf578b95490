#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <cstddef>
#include <cstring>

#include "gpu/host/pipeline.h"
#include "reference/base/error.h"
#include "verify/backends/cuda/cuda_backend.h"

namespace scotty::verify {

namespace {

void copy_in_parallel(void* to, const void* from, std::size_t bytes) {
    constexpr std::size_t kGrain = 1u << 20;
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, bytes, kGrain),
                              [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                                  std::memcpy(static_cast<std::byte*>(to) + range.begin(),
                                              static_cast<const std::byte*>(from) + range.begin(),
                                              range.size());
                              });
}

}  // namespace

Backend cuda_backend() {
    const auto device = gpu::find_device();
    if (!device) {
        throw reference::Error::missing_environment(
            "back end cuda: no CUDA device on this machine (scotty doctor says what there is)");
    }
    Backend backend;
    backend.name = "cuda";
    backend.has_fast_arithmetic = true;
    backend.free_memory = device->free_bytes;
    backend.make = [](const reference::Scene& scene, const reference::WideBvh& bvh,
                      const reference::PipelineParameters& p, const PipelineMaking& making) {
        return gpu::make_pipeline(
            scene, bvh, p, {.timings = making.timed, .copy = copy_in_parallel}, making.observer);
    };
    return backend;
}

std::optional<CudaDescription> find_cuda() {
    const std::optional<gpu::DeviceInfo> info = gpu::find_device();
    if (!info) return std::nullopt;
    const auto version = [](int number) {
        return fmt::format("{}.{}", number / 1000, number % 1000 / 10);
    };
    return CudaDescription{info->name,
                           fmt::format("{}.{}", info->compute_major, info->compute_minor),
                           info->multiprocessors,
                           info->memory_bytes,
                           version(info->driver_version),
                           version(info->runtime_version)};
}

}  // namespace scotty::verify
