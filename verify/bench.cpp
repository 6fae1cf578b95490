#include "verify/bench.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <span>

#include "reference/assert.h"
#include "reference/embree_renderer.h"
#include "reference/tracers.h"
#include "reference/wide_bvh.h"

namespace scotty::verify {

using emulation::LaunchRecord;
using emulation::Pipeline;
using emulation::TraversalKind;
using reference::Hit;
using reference::kNotApplicable;
using reference::Ray;
using reference::StageKind;
using reference::StageView;

namespace {

using Clock = std::chrono::steady_clock;

template <class Work>
double timed(const Work& work) {
    const auto start = Clock::now();
    work();
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Keeps the living rays of every traversal, as the merge reads them.
class RayCollector : public reference::StageObserver {
 public:
    bool wants(StageKind kind) const override { return kind == StageKind::merge_intersections; }

    void on_stage(const StageView& stage) override {
        const bool shadow = stage.light != kNotApplicable;
        const std::string kind = shadow              ? "shadow"
                                 : stage.bounce == 0 ? "primary"
                                                     : "bounce " + std::to_string(stage.bounce);
        std::vector<Ray>& rays = rays_of(kind);
        for (const Ray& ray : stage.get<Ray>("rays")) {
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

class Bench {
 public:
    Bench(const reference::Scene& scene, const BenchSettings& settings)
        : scene_(scene),
          settings_(settings),
          bvh_(build_wide_bvh(scene, bvh_parameters(settings.parameters, settings.threads))),
          embree_(scene) {}

    BenchReport run() {
        static_cast<BenchSubject&>(report_) = subject_of(scene_, settings_);
        time_renders();
        say("collecting rays");
        RayCollector collector;
        Pipeline(scene_, bvh_, settings_.parameters, {settings_.threads}, &collector).render();
        report_.all.kind = "all";
        for (auto& [kind, rays] : collector.kinds()) {
            if (rays.empty()) continue;
            time_kind(kind, rays);
            std::vector<Ray>().swap(rays);
        }
        return std::move(report_);
    }

 private:
    void say(const std::string& what) const {
        if (settings_.progress) settings_.progress(what);
    }

    /// Both tracers on the rays of one kind, by turns; the medians count.
    void time_kind(const std::string& kind, std::span<const Ray> rays) {
        const bool any =
            kind == "shadow" && settings_.parameters.shadow_query == reference::ShadowQuery::any;
        Pipeline pipeline(scene_, bvh_, settings_.parameters, {settings_.threads});
        std::vector<Hit> hits(rays.size());
        std::vector<std::uint8_t> occluded(any ? rays.size() : 0);
        std::vector<double> ours;
        std::vector<double> theirs;
        for (int round = -settings_.warm_ups; round < settings_.repeats; ++round) {
            say(kind + " rays, round " + std::to_string(round + settings_.warm_ups + 1));
            const double emulator = timed([&] {
                pipeline.trace(rays, any ? TraversalKind::any : TraversalKind::closest, hits);
            });
            pipeline.clear_launches();
            const double embree = timed([&] {
                if (any) {
                    embree_.occluded(rays, occluded);
                } else {
                    embree_.closest(rays, hits);
                }
            });
            if (round < 0) continue;
            ours.push_back(emulator);
            theirs.push_back(embree);
        }
        report_.kinds.push_back({kind, rays.size(), median(ours), median(theirs)});
        report_.all.rays += rays.size();
        report_.all.emulator_seconds += report_.kinds.back().emulator_seconds;
        report_.all.embree_seconds += report_.kinds.back().embree_seconds;
    }

    /// Whole renders; the launches of the median one are added up.
    void time_renders() {
        Pipeline pipeline(scene_, bvh_, settings_.parameters, {settings_.threads});
        std::vector<std::pair<double, std::vector<LaunchRecord>>> renders;
        std::vector<double> theirs;
        for (int round = -settings_.warm_ups; round < settings_.repeats; ++round) {
            say("rendering, round " + std::to_string(round + settings_.warm_ups + 1));
            pipeline.clear_launches();
            const double ours = timed([&] { pipeline.render(); });
            const double embree = timed([&] {
                render_with_embree(scene_, settings_.parameters, embree_, settings_.threads);
            });
            if (round < 0) continue;
            renders.emplace_back(ours, pipeline.launches());
            theirs.push_back(embree);
        }
        std::sort(renders.begin(), renders.end(),
                  [](const auto& a, const auto& b) { return a.first < b.first; });
        const auto& middle = renders[(renders.size() - 1) / 2];
        report_.render_seconds = middle.first;
        report_.embree_render_seconds = median(theirs);
        report_.device_bytes = pipeline.device_bytes();
        std::map<std::string, BenchPart> stages;
        std::map<std::uint32_t, BenchPart> levels;
        const auto add = [](BenchPart& part, std::string name, const LaunchRecord& launch) {
            part.name = std::move(name);
            part.seconds += launch.seconds;
            part.launches += 1;
            part.blocks += launch.blocks;
            part.items += launch.items;
        };
        for (const LaunchRecord& launch : middle.second) {
            add(stages[to_string(launch.kind)], to_string(launch.kind), launch);
            const bool traverses =
                launch.kind == StageKind::intersect_root || launch.kind == StageKind::intersect;
            if (traverses) {
                add(levels[launch.level], "level " + std::to_string(launch.level), launch);
            }
        }
        for (auto& [name, part] : stages) report_.stages.push_back(part);
        std::sort(report_.stages.begin(), report_.stages.end(),
                  [](const BenchPart& a, const BenchPart& b) { return a.seconds > b.seconds; });
        for (auto& [level, part] : levels) report_.levels.push_back(part);
    }

    const reference::Scene& scene_;
    const BenchSettings& settings_;
    reference::WideBvh bvh_;
    reference::EmbreeTracer embree_;
    BenchReport report_;
};

}  // namespace

double median(std::vector<double> values) {
    SCOTTY_ASSERT(values.size(), >, 0u);
    std::sort(values.begin(), values.end());
    return values[(values.size() - 1) / 2];
}

BenchReport bench_emulator(const reference::Scene& scene, const BenchSettings& settings) {
    reference::validate(settings.parameters);
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    return Bench(scene, settings).run();
}

}  // namespace scotty::verify
