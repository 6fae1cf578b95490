#include "verify/bench/bench.h"

#include <tbb/global_control.h>

#include <chrono>
#include <optional>
#include <utility>

#include "reference/contract/wide_bvh.h"
#include "reference/truth/embree_renderer.h"
#include "reference/truth/tracers.h"

namespace scotty::verify {

namespace {

/// What every measurement of a scene needs; while it lives, TBB and with it Embree's tracing are
/// held to the threads asked for.
struct Prepared {
    Prepared(const reference::Scene& scene, const BenchSettings& settings) : embree(scene) {
        reference::validate(settings.parameters);
        if (settings.threads != 0) {
            limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
        }
        bvh = build_wide_bvh(scene, bvh_parameters(settings.parameters, settings.threads));
    }

    std::optional<tbb::global_control> limit;
    reference::EmbreeTracer embree;
    reference::WideBvh bvh;
};

Spread embree_renders(const reference::Scene& scene, const BenchSettings& settings,
                      const reference::EmbreeTracer& embree) {
    std::vector<double> seconds;
    for (int round = -settings.warm_ups; round < settings.repeats; ++round) {
        if (settings.progress) {
            settings.progress("rendering with Embree, round " +
                              std::to_string(round + settings.warm_ups + 1));
        }
        const auto start = std::chrono::steady_clock::now();
        render_with_embree(scene, settings.parameters, embree, settings.threads);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        if (round >= 0) seconds.push_back(taken.count());
    }
    return spread_of(std::move(seconds));
}

}  // namespace

BenchReport bench_backend(const reference::Scene& scene, const BenchSettings& settings,
                          const std::string& backend) {
    const Prepared prepared(scene, settings);
    const reference::EmbreeTracer& embree = prepared.embree;
    const reference::WideBvh& bvh = prepared.bvh;
    BenchReport report;
    static_cast<BenchSubject&>(report) = subject_of(scene, settings);
    report.renders = measure_renders(scene, bvh,
                                     {settings.parameters, backend, settings.threads,
                                      settings.warm_ups, settings.repeats, settings.progress});
    report.parts = parts_of(report.renders.launches, bvh, settings.parameters);
    report.embree_render = embree_renders(scene, settings, embree);
    report.rays = trace_by_turns(scene, bvh, embree, settings, backend);
    report.occupancy =
        count_occupancy(scene, bvh, settings.parameters, settings.threads, settings.progress);
    return report;
}

EmbreeBenchReport bench_embree(const reference::Scene& scene, const BenchSettings& settings) {
    const Prepared prepared(scene, settings);
    const reference::EmbreeTracer& embree = prepared.embree;
    const reference::WideBvh& bvh = prepared.bvh;
    EmbreeBenchReport report;
    static_cast<BenchSubject&>(report) = subject_of(scene, settings);
    report.render = embree_renders(scene, settings, embree);
    report.rays = trace_by_turns(scene, bvh, embree, settings, "");
    return report;
}

}  // namespace scotty::verify
