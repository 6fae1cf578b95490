#include "verify/bench/measure.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "verify/backends/backend.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Error;
using reference::LaunchRecord;
using reference::PipelineParameters;
using reference::Scene;
using reference::StageKind;
using reference::StageObserver;
using reference::StageView;
using reference::WideBvh;

namespace {

/// Counts the living rays of every traversal, as the merge reads them.
class RayCounter : public StageObserver {
 public:
    bool wants(StageKind kind) const override { return kind == StageKind::merge_intersections; }
    void on_stage(const StageView& stage) override {
        const std::string kind = kind_of_rays(stage);
        const auto found = std::find_if(counts.begin(), counts.end(),
                                        [&](const RayCount& count) { return count.kind == kind; });
        RayCount& count = found != counts.end() ? *found : counts.emplace_back(RayCount{kind, 0});
        const auto rays = stage.get(buffers::rays);
        count.rays += static_cast<std::uint64_t>(std::count_if(
            rays.begin(), rays.end(), [](const reference::Ray& ray) { return !is_dead(ray); }));
    }

    std::vector<RayCount> counts;
};

double sum_of(const std::vector<LaunchRecord>& launches) {
    return std::accumulate(
        launches.begin(), launches.end(), 0.0,
        [](double sum, const LaunchRecord& launch) { return sum + launch.seconds; });
}

/// Renders of one pipeline: the clock of each, and its launches.
struct Rounds {
    std::vector<double> seconds;
    std::vector<std::vector<LaunchRecord>> launches;
    reference::Image image;
};

Rounds render_rounds(reference::PipelineInterface& pipeline, const RenderSettings& settings,
                     const char* what) {
    Rounds rounds;
    for (int round = -settings.warm_ups; round < settings.repeats; ++round) {
        if (settings.progress) {
            settings.progress(fmt::format("{}: {}, round {}", settings.backend, what,
                                          round + settings.warm_ups + 1));
        }
        pipeline.clear_launches();
        const auto start = std::chrono::steady_clock::now();
        rounds.image = pipeline.render();
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        if (round < 0) continue;
        rounds.seconds.push_back(taken.count());
        rounds.launches.push_back(pipeline.launches());
    }
    return rounds;
}

/// The round whose value is the median.
std::size_t middle_of(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    return order[(order.size() - 1) / 2];
}

/// The launches of the round in the middle, by the clock or, of `cuda`, by their sum.
void keep_launches(Rounds& rounds, bool by_sum, MeasuredRenders& out) {
    std::vector<double> sums;
    for (const auto& launches : rounds.launches) sums.push_back(sum_of(launches));
    out.launches = std::move(rounds.launches[middle_of(by_sum ? sums : rounds.seconds)]);
    out.launch_seconds = spread_of(std::move(sums));
}

}  // namespace

Spread spread_of(std::vector<double> values) {
    SCOTTY_ASSERT(values.size(), >, 0u);
    std::sort(values.begin(), values.end());
    const auto last = values.size() - 1;
    return {values[0], values[last / 4], values[last / 2], values[last - last / 4], values[last]};
}

Spread operator+(const Spread& a, const Spread& b) {
    return {a.least + b.least, a.lower_quartile + b.lower_quartile, a.median + b.median,
            a.upper_quartile + b.upper_quartile, a.most + b.most};
}

std::string readable_seconds(const Spread& seconds) {
    return fmt::format("{:.2f} ms ({:.2f} to {:.2f})", 1e3 * seconds.median, 1e3 * seconds.least,
                       1e3 * seconds.most);
}

nlohmann::json to_json(const Spread& spread) {
    return {{"median", spread.median},
            {"least", spread.least},
            {"lower_quartile", spread.lower_quartile},
            {"upper_quartile", spread.upper_quartile},
            {"most", spread.most}};
}

std::unique_ptr<reference::PipelineInterface> make_pipeline_of(const std::string& backend,
                                                               const Scene& scene,
                                                               const WideBvh& bvh,
                                                               const PipelineParameters& parameters,
                                                               std::size_t threads, bool timed,
                                                               StageObserver* observer) {
    const Backend of = backend_named(backend, threads);
    expect_arithmetic(of, parameters);
    return of.make(scene, bvh, parameters, {.observer = observer, .timed = timed});
}

MeasuredRenders measure_renders(const Scene& scene, const WideBvh& bvh,
                                const RenderSettings& settings) {
    reference::validate(settings.parameters);
    if (settings.repeats < 1) {
        throw Error::bad_input("--repeats",
                               fmt::format("expected 1 or more, found {}", settings.repeats));
    }
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    const auto make = [&](bool timed, StageObserver* observer) {
        return make_pipeline_of(settings.backend, scene, bvh, settings.parameters, settings.threads,
                                timed, observer);
    };
    const bool events = settings.backend == "cuda";
    MeasuredRenders out;
    out.backend = settings.backend;
    {
        const auto pipeline = make(!events, nullptr);
        Rounds rounds = render_rounds(*pipeline, settings, "rendering");
        out.all_seconds = rounds.seconds;
        out.seconds = spread_of(rounds.seconds);
        out.device_bytes = pipeline->device_bytes();
        out.image = std::move(rounds.image);
        if (!events) keep_launches(rounds, false, out);
    }
    if (events) {
        const auto pipeline = make(true, nullptr);
        Rounds rounds = render_rounds(*pipeline, settings, "rendering with events");
        keep_launches(rounds, true, out);
    }
    if (settings.progress) settings.progress(settings.backend + ": counting rays");
    RayCounter counter;
    make(false, &counter)->render();
    out.rays = std::move(counter.counts);
    return out;
}

MeasuredRenders measure_renders(const Scene& scene, const RenderSettings& settings) {
    reference::validate(settings.parameters);
    return measure_renders(
        scene, build_wide_bvh(scene, bvh_parameters(settings.parameters, settings.threads)),
        settings);
}

}  // namespace scotty::verify
