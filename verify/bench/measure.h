/// Renders of one scene on one back end, timed: what `scotty bench` prints and other commands
/// build on.
///
///     RenderSettings settings;
///     settings.backend = "cuda";
///     const MeasuredRenders renders = measure_renders(scene, bvh, settings);
///     renders.seconds.median;  // of a whole render, wall clock
///     renders.launches;        // of the median one, each with its seconds
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/pipeline_interface.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"
#include "verify/backends/machine.h"

namespace scotty::verify {

/// The repeats of one measurement in order of size. Each is one that was measured: of an even
/// number the median is the lower of the middle two, and quartiles are nearest ranks.
struct Spread {
    double least = 0.0, lower_quartile = 0.0, median = 0.0, upper_quartile = 0.0, most = 0.0;

    /// Between the quartiles, as a part of the median: 0.02 is 2 %.
    double relative() const {
        return median > 0.0 ? (upper_quartile - lower_quartile) / median : 0.0;
    }
};
/// At least one value.
Spread spread_of(std::vector<double> values);
/// Of measurements that were not made together, each figure added up: bounds, not a spread.
Spread operator+(const Spread& a, const Spread& b);
/// "12.34 ms (12.20 to 13.01)": the median, the least and the most.
std::string readable_seconds(const Spread& seconds);
/// Keys median, least, lower_quartile, upper_quartile, most.
nlohmann::json to_json(const Spread& spread);

struct RenderSettings {
    reference::PipelineParameters parameters;
    std::string backend = "emulator";  ///< or "simt", "cuda": backend_names()
    std::size_t threads = 0;           ///< of the CPU, for emulator and simt; 0: all
    int warm_ups = 1;                  ///< renders before those that count, 0 or more
    int repeats = 3;                   ///< renders that count, 1 or more
    std::function<void(const std::string&)> progress;  ///< hears what is being done; may be empty
};

/// Rays of one kind that a render traces, those that are dead not counted.
struct RayCount {
    std::string kind;  ///< "primary", "bounce 1", "bounce 2", ..., "shadow"
    std::uint64_t rays = 0;
};

struct MeasuredRenders {
    std::string backend;
    std::vector<double> all_seconds;  ///< of each repeat, in the order in which they ran
    Spread seconds;                   ///< of whole renders, wall clock, from call to image
    /// Of the median render, in order; batches one after the other. The emulator's and the
    /// executor's are timed by the clock. Those of cuda are timed by events on the device, in
    /// renders of their own, `repeats` more, of which this is the one with the median sum:
    /// recording events costs time, and the wall clock's renders record none.
    std::vector<reference::LaunchRecord> launches;
    Spread launch_seconds;  ///< what the launches of each such render add up to
    /// In the order in which they first appear; by an observed render that is not timed.
    std::vector<RayCount> rays;
    std::uint64_t device_bytes = 0;  ///< in buffers of the device (or the emulator's), at the end
    reference::Image image;          ///< the last one
};

/// Throws bad_input for a back end of no such name, parameters out of range and repeats < 1, and
/// missing_environment where this machine or this build cannot serve the back end.
/// bvh.width == settings.parameters.width; scene and BVH are borrowed for the call.
MeasuredRenders measure_renders(const reference::Scene& scene, const reference::WideBvh& bvh,
                                const RenderSettings& settings);
/// The same with a BVH that it builds; the build is not timed.
MeasuredRenders measure_renders(const reference::Scene& scene, const RenderSettings& settings);

/// The back end's pipeline behind one interface. `timed`: launches carry their seconds (the
/// emulator's always do). Throws as measure_renders().
std::unique_ptr<reference::PipelineInterface> make_pipeline_of(
    const std::string& backend, const reference::Scene& scene, const reference::WideBvh& bvh,
    const reference::PipelineParameters& parameters, std::size_t threads, bool timed = false,
    reference::StageObserver* observer = nullptr);

/// What the rays of a stage of a traversal are called: "primary", "bounce N", "shadow", and "given"
/// where they came from elsewhere; empty for stages of no traversal. `S`: StageView or
/// LaunchRecord.
template <class S>
std::string kind_of_rays(const S& stage) {
    if (!reference::is_of_traversal(stage.kind) &&
        stage.kind != reference::StageKind::merge_intersections) {
        return "";
    }
    if (stage.light != reference::kNotApplicable) return "shadow";
    if (stage.bounce == reference::kNotApplicable) return "given";
    return stage.bounce == 0 ? "primary" : "bounce " + std::to_string(stage.bounce);
}

}  // namespace scotty::verify
