/// The renders behind the analyses.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "verify/analysis/analysis.h"
#include "verify/analysis/analysis_census.h"
#include "verify/bench/measure.h"

namespace scotty::verify {

/// The repeats of one render.
struct RenderRounds {
    std::vector<double> seconds;  ///< wall clock, from call to image
    /// Each launch with its seconds. On cuda they come from separate renders: events cost time.
    std::vector<std::vector<reference::LaunchRecord>> launches;

    /// The sum of the `wanted` launches in each repeat.
    std::vector<double> sums(
        const std::function<bool(const reference::LaunchRecord&)>& wanted) const;
};

/// Median, least and most of the values, times `unit`.
AnalysisPoint point_of(double x, const std::string& label, const std::vector<double>& values,
                       double unit);

/// Renders on one scene and back end.
class AnalysisRenders {
 public:
    /// Thrown when the caller's stop() says so.
    struct Stopped {};

    /// The scene is borrowed. `stop` may be empty.
    AnalysisRenders(const reference::Scene& scene, RenderSettings settings,
                    std::function<bool()> stop);

    /// Renders each of `all` in turn, so that the machine's other work and its warmth affect all of
    /// them alike. All rays of a render are in one traversal; throws missing_environment if the
    /// device has no room for that.
    std::vector<RenderRounds> by_turns(const std::vector<reference::PipelineParameters>& all);
    /// One render that is observed and not timed.
    std::vector<QueryCensus> counted(const reference::PipelineParameters& parameters);
    /// The size of the buffers at the end of a render, which is not timed.
    std::uint64_t device_bytes(const reference::PipelineParameters& parameters);

 private:
    std::unique_ptr<reference::PipelineInterface> pipeline(
        const reference::PipelineParameters& parameters, bool timed,
        reference::StageObserver* observer);
    void take_turns(const std::vector<reference::PipelineParameters>& all, bool timed,
                    std::vector<RenderRounds>& out);
    void begin(const std::string& what);

    const reference::Scene& scene_;
    RenderSettings settings_;
    std::function<bool()> stop_;
    std::map<std::string, reference::WideBvh> bvhs_;
};

}  // namespace scotty::verify
