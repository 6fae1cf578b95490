#include "reference/truth/path_tracer.h"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "reference/truth/path_estimator.h"
#include "reference/truth/path_tracer_state.h"

namespace scotty::reference {

namespace {

constexpr std::uint32_t kPixelsPerTask = 32;

/// A pixel's samples are added in their order by one task, so that nothing depends on threads.
void add_samples(const PathEstimator& estimator, std::uint64_t last, SampleSums& sums) {
    const auto pixels = static_cast<std::uint32_t>(sums.sum.size());
    oneapi::tbb::parallel_for(
        oneapi::tbb::blocked_range<std::uint32_t>(0, pixels, kPixelsPerTask),
        [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
            for (std::uint32_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                for (std::uint64_t sample = sums.samples; sample < last; ++sample) {
                    const Double3 radiance = estimator.radiance(pixel, sample);
                    sums.add(pixel, {radiance.x, radiance.y, radiance.z});
                }
            }
        });
    sums.samples = last;
}

}  // namespace

SampleSums trace_paths(const Scene& scene, const PipelineParameters& parameters,
                       const PathTracerOptions& options) {
    validate(parameters);
    SCOTTY_ASSERT(options.samples_a_round, >, 0u);
    const PathTracerState state(options.state, scene, parameters);
    SampleSums sums = state.load();
    if (sums.samples > parameters.spp) {
        throw Error::bad_input(
            options.state.string(),
            fmt::format("holds {} samples per pixel, more than the {} asked for; ask for as many, "
                        "or remove it",
                        sums.samples, parameters.spp));
    }
    const PathEstimator estimator(scene, parameters);
    oneapi::tbb::task_arena arena(options.threads == 0 ? oneapi::tbb::task_arena::automatic
                                                       : static_cast<int>(options.threads));
    while (sums.samples < parameters.spp) {
        const std::uint64_t last =
            std::min<std::uint64_t>(parameters.spp, sums.samples + options.samples_a_round);
        arena.execute([&] { add_samples(estimator, last, sums); });
        state.save(sums);
        if (options.progress) options.progress(sums.samples, parameters.spp);
    }
    return sums;
}

}  // namespace scotty::reference
