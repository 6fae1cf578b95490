#include "verify/analysis/analysis_renders.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "reference/base/error.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::verify {

using reference::Error;
using reference::LaunchRecord;
using reference::PipelineParameters;

namespace {

/// Makes room for all rays of the render in one batch.
PipelineParameters in_one_batch(PipelineParameters p) {
    constexpr std::uint64_t kMostRays = 1u << 28;  // the limit of reference::validate()
    const std::uint64_t rays = std::uint64_t{p.image_width} * p.image_height * p.spp;
    if (rays == 0 || rays > kMostRays) {
        throw Error::bad_input(
            "--size", fmt::format("{}x{} with {} samples is {} rays; 1 to {} can be in a traversal",
                                  p.image_width, p.image_height, p.spp, rays, kMostRays));
    }
    p.batch_rays = static_cast<std::uint32_t>(rays);
    reference::validate(p);
    return p;
}

}  // namespace

std::vector<double> RenderRounds::sums(
    const std::function<bool(const LaunchRecord&)>& wanted) const {
    std::vector<double> out;
    out.reserve(launches.size());
    for (const std::vector<LaunchRecord>& round : launches) {
        double sum = 0.0;
        for (const LaunchRecord& launch : round) sum += wanted(launch) ? launch.seconds : 0.0;
        out.push_back(sum);
    }
    return out;
}

AnalysisPoint point_of(double x, const std::string& label, const std::vector<double>& values,
                       double unit) {
    const Spread spread = spread_of(values);
    return {x, label, unit * spread.median, unit * spread.least, unit * spread.most};
}

AnalysisRenders::AnalysisRenders(const reference::Scene& scene, RenderSettings settings,
                                 std::function<bool()> stop)
    : scene_(scene), settings_(std::move(settings)), stop_(std::move(stop)) {}

void AnalysisRenders::begin(const std::string& what) {
    if (stop_ && stop_()) throw Stopped();
    if (settings_.progress) settings_.progress(what);
}

std::unique_ptr<reference::PipelineInterface> AnalysisRenders::pipeline(
    const PipelineParameters& p, bool timed, reference::StageObserver* observer) {
    const std::string key = fmt::format("{} {} {}", p.width, p.max_leaf_size, p.queue_levels);
    auto found = bvhs_.find(key);
    if (found == bvhs_.end()) {
        const auto shape = bvh_parameters(p, settings_.threads);
        found = bvhs_.emplace(key, build_wide_bvh(scene_, shape)).first;
    }
    return make_pipeline_of(settings_.backend, scene_, found->second, p, settings_.threads, timed,
                            observer);
}

void AnalysisRenders::take_turns(const std::vector<PipelineParameters>& all, bool timed,
                                 std::vector<RenderRounds>& out) {
    std::vector<std::unique_ptr<reference::PipelineInterface>> pipelines;
    pipelines.reserve(all.size());
    for (const PipelineParameters& p : all) {
        pipelines.push_back(pipeline(in_one_batch(p), timed, nullptr));
    }
    for (int round = -settings_.warm_ups; round < settings_.repeats; ++round) {
        for (std::size_t i = 0; i < all.size(); ++i) {
            begin(fmt::format("round {} of {}, render {} of {}", round + settings_.warm_ups + 1,
                              settings_.warm_ups + settings_.repeats, i + 1, all.size()));
            pipelines[i]->clear_launches();
            const auto start = std::chrono::steady_clock::now();
            pipelines[i]->render();
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            if (round < 0) continue;
            out[i].seconds.push_back(taken.count());
            out[i].launches.push_back(pipelines[i]->launches());
            const auto& launches = out[i].launches.back();
            if (!launches.empty() && launches.back().batch != 0) {
                throw Error::missing_environment(fmt::format(
                    "the device has no memory for {} rays in one traversal; a smaller --size",
                    in_one_batch(all[i]).batch_rays));
            }
        }
    }
}

std::vector<RenderRounds> AnalysisRenders::by_turns(const std::vector<PipelineParameters>& all) {
    std::optional<tbb::global_control> limit;
    if (settings_.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings_.threads);
    }
    const bool events = settings_.backend == "cuda";
    std::vector<RenderRounds> out(all.size());
    take_turns(all, !events, out);
    if (!events) return out;
    std::vector<RenderRounds> with_events(all.size());
    take_turns(all, true, with_events);
    for (std::size_t i = 0; i < all.size(); ++i) {
        out[i].launches = std::move(with_events[i].launches);
    }
    return out;
}

std::vector<QueryCensus> AnalysisRenders::counted(const PipelineParameters& parameters) {
    begin("counting queue entries");
    const PipelineParameters p = in_one_batch(parameters);
    QueueCensus census(static_cast<std::uint32_t>(p.rays_per_block));
    pipeline(p, false, &census)->render();
    return census.queries();
}

std::uint64_t AnalysisRenders::device_bytes(const PipelineParameters& parameters) {
    begin("measuring memory");
    const auto rendered = pipeline(in_one_batch(parameters), false, nullptr);
    rendered->render();
    return rendered->device_bytes();
}

}  // namespace scotty::verify
