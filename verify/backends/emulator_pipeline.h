/// The emulator behind the interface that the pipelines of gpu/ have.
#pragma once

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

#include "emulation/host/pipeline.h"
#include "gpu/host/pipeline.h"

namespace scotty::verify {

class EmulatorPipeline final : public gpu::Pipeline {
 public:
    EmulatorPipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                     const reference::PipelineParameters& parameters, std::size_t threads,
                     reference::StageObserver* observer)
        : pipeline_(scene, bvh, parameters, {threads}, observer) {}

    reference::Image render() override { return pipeline_.render(); }
    void trace(std::span<const reference::Ray> rays, reference::TraversalKind kind,
               std::span<reference::Hit> hits) override {
        pipeline_.trace(rays, kind, hits);
    }
    /// By the clock.
    double time_trace(std::span<const reference::Ray> rays, reference::TraversalKind kind,
                      int repeats) override {
        std::vector<reference::Hit> hits(rays.size());
        std::vector<double> seconds;
        for (int round = -2; round < repeats; ++round) {
            const auto start = std::chrono::steady_clock::now();
            pipeline_.trace(rays, kind, hits);
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            if (round >= 0) seconds.push_back(taken.count());
        }
        std::sort(seconds.begin(), seconds.end());
        return seconds[seconds.size() / 2];
    }
    const std::vector<reference::LaunchRecord>& launches() override { return pipeline_.launches(); }
    void clear_launches() override { pipeline_.clear_launches(); }
    std::size_t device_bytes() const override { return pipeline_.device_bytes(); }

 private:
    emulation::Pipeline pipeline_;
};

}  // namespace scotty::verify
