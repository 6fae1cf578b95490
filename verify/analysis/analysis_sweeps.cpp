/// Analyses of whole renders with one parameter changed.
#include <fmt/format.h>

#include <vector>

#include "verify/analysis/analysis_parts.h"

namespace scotty::verify {

using reference::PipelineParameters;

namespace {

double rays_of(const PipelineParameters& p) {
    return static_cast<double>(std::uint64_t{p.image_width} * p.image_height * p.spp);
}

/// In milliseconds; "kernels, ms" is the sum of the launches.
AnalysisPoint render_time(double x, const std::string& label, const RenderRounds& rounds) {
    AnalysisPoint point = point_of(x, label, rounds.seconds, 1e3);
    const auto kernels = rounds.sums([](const reference::LaunchRecord&) { return true; });
    point.more.emplace_back("kernels, ms", 1e3 * spread_of(kernels).median);
    return point;
}

/// Renders with one parameter changed, in turn.
template <class Value, class Change>
AnalysisSeries sweep(AnalysisRenders& renders, const PipelineParameters& base,
                     const std::vector<Value>& values, const Change& change) {
    std::vector<PipelineParameters> all(values.size(), base);
    for (std::size_t i = 0; i < values.size(); ++i) change(all[i], values[i]);
    const std::vector<RenderRounds> rounds = renders.by_turns(all);
    AnalysisSeries series;
    for (std::size_t i = 0; i < values.size(); ++i) {
        series.points.push_back(render_time(static_cast<double>(values[i]), "", rounds[i]));
    }
    return series;
}

/// Samples per pixel that give the traversals' sizes; more on a device, which is faster.
std::vector<std::uint32_t> sample_counts(const AnalysisSettings& settings) {
    if (settings.quick) return {1, 2, 4};
    if (settings.render.backend == "cuda") return {1, 2, 4, 8, 16, 32, 64};
    return {1, 2, 4, 8, 16};
}

}  // namespace

AnalysisResult analyze_rays(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"rays", usual(settings), {}};
    AnalysisSeries series = sweep(renders, result.parameters, sample_counts(settings),
                                  [](PipelineParameters& p, std::uint32_t spp) { p.spp = spp; });
    PipelineParameters one = result.parameters;
    one.spp = 1;
    for (AnalysisPoint& point : series.points) point.x *= rays_of(one);
    result.series.push_back(std::move(series));
    return result;
}

AnalysisResult analyze_width(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"width", usual(settings), {}};
    result.series.push_back(sweep(renders, result.parameters, std::vector<int>{2, 4, 8, 16},
                                  [](PipelineParameters& p, int width) { p.width = width; }));
    return result;
}

AnalysisResult analyze_rays_per_block(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"rays-per-block", usual(settings), {}};
    result.series.push_back(
        sweep(renders, result.parameters, std::vector<int>{32, 64, 128, 256, 512, 1024},
              [](PipelineParameters& p, int rays) { p.rays_per_block = rays; }));
    return result;
}

AnalysisResult analyze_early_out(const AnalysisSettings& settings, AnalysisRenders& renders) {
    using reference::EarlyOut;
    AnalysisResult result{"early-out", usual(settings), {}};
    std::vector<PipelineParameters> all;
    for (const EarlyOut value : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        all.push_back(result.parameters);
        all.back().early_out = value;
    }
    const std::vector<RenderRounds> rounds = renders.by_turns(all);
    AnalysisSeries time;
    AnalysisSeries entries;
    entries.panel = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string label = to_string(all[i].early_out);
        time.points.push_back(render_time(0.0, label, rounds[i]));
        const auto counted = static_cast<double>(entries_of(renders.counted(all[i])));
        entries.points.push_back(exactly(0.0, label, counted));
    }
    result.series = {std::move(time), std::move(entries)};
    return result;
}

AnalysisResult analyze_memory(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"memory", usual(settings), {}};
    for (const int width : {4, 8}) {
        AnalysisSeries series{0, fmt::format("width {}", width), {}};
        for (const std::uint32_t spp : sample_counts(settings)) {
            PipelineParameters p = result.parameters;
            p.width = width;
            p.spp = spp;
            const auto bytes = static_cast<double>(renders.device_bytes(p));
            series.points.push_back(exactly(rays_of(p), "", bytes / rays_of(p)));
            series.points.back().more.emplace_back("MiB", bytes / (1024.0 * 1024.0));
        }
        result.series.push_back(std::move(series));
    }
    return result;
}

}  // namespace scotty::verify
