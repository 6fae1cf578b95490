#include "verify/bench/bench_rays.h"
#include "emulation/host/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Hit;
using reference::HitCandidate;
using reference::Ray;
using reference::StageKind;
using reference::StageView;
using reference::TraversalKind;

namespace {

/// Keeps the living rays of every traversal, as the merge reads them.
class RayCollector : public reference::StageObserver {
 public:
    bool wants(StageKind kind) const override { return kind == StageKind::merge_intersections; }

    void on_stage(const StageView& stage) override {
        std::vector<Ray>& rays = rays_of(kind_of_rays(stage));
        for (const Ray& ray : stage.get(buffers::rays)) {
            if (!is_dead(ray)) rays.push_back(ray);
        }
    }

    std::vector<std::pair<std::string, std::vector<Ray>>>& kinds() { return kinds_; }

 private:
    std::vector<Ray>& rays_of(const std::string& kind) {
        for (auto& [name, rays] : kinds_) {
            if (name == kind) return rays;
        }
        return kinds_.emplace_back(kind, std::vector<Ray>()).second;
    }

    std::vector<std::pair<std::string, std::vector<Ray>>> kinds_;
};

template <class Work>
double clocked(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Seconds on the device.
double time_in_batches(reference::PipelineInterface& pipeline, std::span<const Ray> rays,
                       TraversalKind kind, std::size_t batch) {
    double seconds = 0.0;
    for (std::size_t first = 0; first < rays.size(); first += batch) {
        seconds +=
            pipeline.time_trace(rays.subspan(first, std::min(batch, rays.size() - first)), kind, 1);
    }
    return seconds;
}

/// One round of each tracer after the other.
class Turns {
 public:
    Turns(const reference::Scene& scene, const reference::WideBvh& bvh,
          const reference::EmbreeTracer& embree, const BenchSettings& settings,
          const std::string& backend)
        : settings_(settings), embree_(embree), on_device_(backend == "cuda") {
        if (backend.empty()) return;
        pipeline_ = make_pipeline_of(backend, scene, bvh, settings.parameters, settings.threads);
    }

    BenchRays time(const std::string& kind, std::span<const Ray> rays) {
        const bool any = asks_any(kind);
        hits_.resize(rays.size());
        occluded_.resize(any ? rays.size() : 0);
        std::vector<double> ours;
        std::vector<double> theirs;
        for (int round = -settings_.warm_ups; round < settings_.repeats; ++round) {
            if (settings_.progress) {
                settings_.progress(
                    fmt::format("{} rays, round {}", kind, round + settings_.warm_ups + 1));
            }
            const double our_turn = pipeline_ == nullptr ? 0.0 : time_ours(rays, any);
            const double embrees_turn = clocked([&] {
                if (any) {
                    embree_.occluded(rays, occluded_);
                } else {
                    embree_.closest(rays, hits_);
                }
            });
            if (round < 0) continue;
            ours.push_back(our_turn);
            theirs.push_back(embrees_turn);
        }
        return {kind, rays.size(), spread_of(std::move(ours)), spread_of(std::move(theirs))};
    }
    bool asks_any(const std::string& kind) const {
        return kind == "shadow" && settings_.parameters.shadow_query == reference::ShadowQuery::any;
    }
    /// Embree's, of the latest kind.
    std::vector<HitCandidate> hits() const {
        std::vector<HitCandidate> out(hits_.size());
        for (std::size_t i = 0; i < out.size(); ++i) {
            out[i] =
                occluded_.empty() ? hit_record(hits_[i], false) : HitCandidate{0.0f, occluded_[i]};
        }
        return out;
    }

 private:
    double time_ours(std::span<const Ray> rays, bool any) {
        const TraversalKind kind = any ? TraversalKind::any : TraversalKind::closest;
        const double seconds =
            on_device_ ? time_in_batches(*pipeline_, rays, kind, settings_.parameters.batch_rays)
                       : clocked([&] { pipeline_->trace(rays, kind, hits_); });
        pipeline_->clear_launches();
        return seconds;
    }

    const BenchSettings& settings_;
    const reference::EmbreeTracer& embree_;
    bool on_device_;
    std::unique_ptr<reference::PipelineInterface> pipeline_;
    std::vector<Hit> hits_;
    std::vector<std::uint8_t> occluded_;
};

nlohmann::json to_json(const BenchRays& kind, const std::string& backend) {
    nlohmann::json out{{"kind", kind.kind},
                       {"rays", kind.rays},
                       {"embree_seconds", kind.embree.median},
                       {"embree_spread", to_json(kind.embree)},
                       {"embree_rays_per_second", kind.embree_rate()}};
    if (backend.empty()) return out;
    out.update({{backend + "_seconds", kind.ours.median},
                {backend + "_spread", to_json(kind.ours)},
                {backend + "_rays_per_second", kind.our_rate()},
                {"ratio", kind.ratio()}});
    return out;
}

/// Between the quartiles, in percent of the median.
std::string percent(const Spread& spread) { return fmt::format("{:.1f}", 100 * spread.relative()); }

/// By kind, and last of all; Embree's where it is measured alone.
std::vector<Spread> subject_seconds(const TracedRays& rays) {
    const auto seconds = [&](const BenchRays& kind) {
        return rays.backend.empty() ? kind.embree : kind.ours;
    };
    std::vector<Spread> out;
    for (const BenchRays& kind : rays.kinds) out.push_back(seconds(kind));
    out.push_back(seconds(rays.all));
    return out;
}

std::string ray_row(const BenchRays& kind, bool alone) {
    std::string out = fmt::format("{:<10} {:>12}", kind.kind, kind.rays);
    if (!alone) out += fmt::format(" {:>14.3f} {:>7}", kind.our_rate() * 1e-6, percent(kind.ours));
    out += fmt::format(" {:>14.3f} {:>7}", kind.embree_rate() * 1e-6, percent(kind.embree));
    if (!alone) out += fmt::format(" {:>9.3f}", kind.ratio());
    return out + "\n";
}

}  // namespace

TracedRays trace_by_turns(const reference::Scene& scene, const reference::WideBvh& bvh,
                          const reference::EmbreeTracer& embree, const BenchSettings& settings,
                          const std::string& backend) {
    if (settings.progress) settings.progress("collecting rays");
    RayCollector collector;
    reference::PipelineParameters exact = settings.parameters;
    exact.arithmetic = reference::Arithmetic::exact;
    emulation::Pipeline(scene, bvh, exact, {settings.threads}, &collector).render();
    Turns turns(scene, bvh, embree, settings, backend);
    std::optional<PeerRuns> peers;
    if (!settings.peers.empty()) peers.emplace(settings.peers, scene, settings);
    TracedRays out;
    out.backend = backend;
    out.all.kind = "all";
    for (auto& [kind, rays] : collector.kinds()) {
        if (rays.empty()) continue;
        const BenchRays timed = turns.time(kind, rays);
        out.all.rays += timed.rays;
        out.all.ours = out.all.ours + timed.ours;
        out.all.embree = out.all.embree + timed.embree;
        out.kinds.push_back(timed);
        RayFile file{std::move(rays), turns.asks_any(kind)};
        if (peers) peers->run(kind, file, turns.hits());
    }
    if (peers) out.peers = peers->peers();
    return out;
}

std::string table(const TracedRays& rays) {
    const bool alone = rays.backend.empty();
    std::string out = fmt::format("{:<10} {:>12}", "rays", "count");
    if (!alone) out += fmt::format(" {:>14} {:>7}", rays.backend + " M/s", "IQR %");
    out += fmt::format(" {:>14} {:>7}", "Embree M/s", "IQR %");
    out += alone ? "\n" : fmt::format(" {:>9}\n", "ratio");
    for (const BenchRays& kind : rays.kinds) out += ray_row(kind, alone);
    out += ray_row(rays.all, alone);
    if (!rays.peers.empty()) out += "\n" + table(rays.peers, subject_seconds(rays));
    return out;
}

nlohmann::json to_json(const TracedRays& rays) {
    nlohmann::json kinds = nlohmann::json::array();
    for (const BenchRays& kind : rays.kinds) kinds.push_back(to_json(kind, rays.backend));
    nlohmann::json out{{"rays", kinds}, {"all_rays", to_json(rays.all, rays.backend)}};
    if (!rays.backend.empty()) out["ratio_to_embree"] = rays.all.ratio();
    if (!rays.peers.empty()) out["peers"] = to_json(rays.peers, subject_seconds(rays));
    return out;
}

}  // namespace scotty::verify
