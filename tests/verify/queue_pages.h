/// Runs with a fault in them, which goes on through all later launches, for the queue debugger's
/// tests.
#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <string>

#include "tests/verify/capture_tools.h"

namespace scotty::verify::test {

/// Changes a launch's output in the pipeline's own memory, before it is captured.
class FaultyRun : public reference::StageObserver {
 public:
    using Fault = std::function<void(const reference::StageView&)>;
    FaultyRun(std::string stage, Fault fault, reference::StageObserver& to)
        : stage_(std::move(stage)), fault_(std::move(fault)), to_(to) {}
    void on_stage(const reference::StageView& stage) override {
        if (fault_ && stage.name == stage_) fault_(stage);
        to_.on_stage(stage);
    }
    void on_retry(std::string_view stage, std::string_view reason) override {
        to_.on_retry(stage, reason);
    }

 private:
    std::string stage_;
    Fault fault_;
    reference::StageObserver& to_;
};

inline std::span<std::uint32_t> writable(const reference::StageView& stage, const char* name) {
    const auto data = stage.get<std::uint32_t>(name);
    return {const_cast<std::uint32_t*>(data.data()), data.size()};
}

inline Capture make_faulty_capture(const std::filesystem::path& directory,
                                   const PipelineInput& input, const std::string& stage,
                                   const FaultyRun::Fault& fault) {
    CaptureWriter writer(directory, header_of("faulty", input.scene, input.bvh, input.parameters),
                         {});
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
    FaultyRun run(stage, fault, writer);
    emulation::Pipeline(input.scene, input.bvh, input.parameters, {}, &run).render();
    writer.finish();
    return Capture::open(directory);
}

/// Where a ray was lost: the first of the longest child queue, which goes elsewhere from there, is
/// written over it.
struct LostRay {
    std::uint32_t child = 0;  ///< position in the level below
    std::uint32_t ray = 0, twice = 0;
};
inline void lose_a_ray(const reference::StageView& stage, LostRay& lost) {
    const auto counts = stage.get<std::uint32_t>("child_counts");
    const auto offsets = stage.get<std::uint32_t>("child_offsets");
    const auto queue = writable(stage, "child_queue");
    const auto longest = std::max_element(counts.begin(), counts.end());
    lost.child = static_cast<std::uint32_t>(longest - counts.begin());
    const std::size_t at = offsets[lost.child] + *longest / 2;
    lost.ray = queue[at];
    lost.twice = queue[offsets[lost.child]];
    queue[at] = lost.twice;
}

}  // namespace scotty::verify::test
