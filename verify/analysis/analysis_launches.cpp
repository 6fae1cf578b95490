/// Analyses of the launches and queues of a render.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "verify/analysis/analysis_parts.h"

namespace scotty::verify {

using reference::kNotApplicable;
using reference::LaunchRecord;
using reference::PipelineParameters;
using reference::StageKind;

namespace {

bool intersects(const LaunchRecord& launch) {
    return launch.kind == StageKind::intersect_root || launch.kind == StageKind::intersect;
}

/// Whether a launch belongs to a ray-scene query, timed with its merge as in the 2018 paper.
bool is_of_query(const LaunchRecord& launch) {
    return is_of_traversal(launch.kind) || launch.kind == StageKind::merge_intersections;
}

/// Names a query by its number along the path: "direct light 2" is at the second vertex.
std::string query_name(std::uint32_t bounce, std::uint32_t light) {
    if (light != kNotApplicable) return fmt::format("direct light {}", bounce + 1);
    return bounce == 0 ? "primary" : fmt::format("scene rays {}", bounce);
}

/// Whether a launch is an intersection of that level, of the primary traversal or of any.
auto at_level(std::uint32_t level, bool primary_only) {
    return [=](const LaunchRecord& launch) {
        const bool primary = launch.bounce == 0 && launch.light == kNotApplicable;
        return intersects(launch) && launch.level == level && (primary || !primary_only);
    };
}

std::uint32_t level_count(const RenderRounds& rounds) {
    std::uint32_t count = 0;
    for (const LaunchRecord& launch : rounds.launches.front()) {
        if (intersects(launch)) count = std::max(count, launch.level + 1);
    }
    return count;
}

/// Intersection times by level, in milliseconds.
AnalysisSeries by_level(const RenderRounds& rounds, bool primary_only) {
    AnalysisSeries series;
    for (std::uint32_t level = 0; level < level_count(rounds); ++level) {
        series.points.push_back(
            point_of(level, "", rounds.sums(at_level(level, primary_only)), 1e3));
    }
    return series;
}

}  // namespace

AnalysisResult analyze_bounces(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"bounces", sized(settings, 256, 16), {}};
    const RenderRounds rounds = renders.by_turns({result.parameters}).front();
    std::vector<std::string> order;
    std::map<std::string, double> living;
    std::map<std::string, double> entries;
    for (const QueryCensus& query : renders.counted(result.parameters)) {
        const std::string name = query_name(query.bounce, query.light);
        if (!living.contains(name)) order.push_back(name);
        living[name] += static_cast<double>(query.rays);
        entries[name] += static_cast<double>(entries_of({query}));
    }
    AnalysisSeries a_ray;
    AnalysisSeries all;
    all.panel = 1;
    for (const std::string& name : order) {
        if (living[name] == 0.0) continue;  // every path has ended
        const std::vector<double> seconds = rounds.sums([&](const LaunchRecord& launch) {
            return is_of_query(launch) && query_name(launch.bounce, launch.light) == name;
        });
        a_ray.points.push_back(point_of(0.0, name, seconds, 1e9 / living[name]));
        a_ray.points.back().more = {{"rays", living[name]},
                                    {"entries per ray", entries[name] / living[name]}};
        all.points.push_back(point_of(0.0, name, seconds, 1e3));
    }
    result.series = {std::move(a_ray), std::move(all)};
    return result;
}

AnalysisResult analyze_levels(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"levels", sized(settings, 1024, 1), {}};
    result.parameters.width = 4;
    result.parameters.max_leaf_size = 32;
    result.series.push_back(by_level(renders.by_turns({result.parameters}).front(), true));
    return result;
}

AnalysisResult analyze_stages(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"stages", usual(settings), {}};
    const RenderRounds rounds = renders.by_turns({result.parameters}).front();
    AnalysisSeries series;
    for (const char* label : {"traversal", "scans", "publish minimum", "merge", "direct-light rays",
                              "resolve light", "primary rays", "scene rays", "image"}) {
        const auto wanted = [&](const LaunchRecord& launch) {
            return std::string_view(reference::stage_info(launch.kind).label) == label;
        };
        const auto& launches = rounds.launches.front();
        if (std::any_of(launches.begin(), launches.end(), wanted)) {
            series.points.push_back(point_of(0.0, label, rounds.sums(wanted), 1e3));
        }
    }
    result.series.push_back(std::move(series));
    return result;
}

AnalysisResult analyze_strided(const AnalysisSettings& settings, AnalysisRenders& renders) {
    using reference::BlockOrder;
    AnalysisResult result{"strided", usual(settings), {}};
    std::vector<PipelineParameters> all(2, result.parameters);
    all[0].block_order = BlockOrder::linear;
    all[1].block_order = BlockOrder::strided;
    const std::vector<RenderRounds> rounds = renders.by_turns(all);
    for (std::size_t i = 0; i < all.size(); ++i) {
        result.series.push_back(by_level(rounds[i], false));
        result.series.back().name = to_string(all[i].block_order);
    }
    AnalysisSeries ratio;  // of each pair of consecutive renders
    ratio.panel = 1;
    for (std::uint32_t level = 0; level < level_count(rounds[0]); ++level) {
        const std::vector<double> linear = rounds[0].sums(at_level(level, false));
        std::vector<double> ratios = rounds[1].sums(at_level(level, false));
        if (*std::min_element(linear.begin(), linear.end()) <= 0.0) continue;
        for (std::size_t i = 0; i < ratios.size(); ++i) ratios[i] /= linear[i];
        ratio.points.push_back(point_of(level, "", ratios, 1.0));
    }
    result.series.push_back(std::move(ratio));
    return result;
}

AnalysisResult analyze_limited_blocks(const AnalysisSettings& settings, AnalysisRenders& renders) {
    AnalysisResult result{"limited-blocks", usual(settings), {}};
    AnalysisSeries limited{0, "limited", {}};
    AnalysisSeries every{0, "a block for every slot", {}};
    for (const QueryCensus& query : renders.counted(result.parameters)) {
        if (!query.primary()) continue;
        for (std::size_t level = 0; level < query.levels.size(); ++level) {
            const LevelCensus& census = query.levels[level];
            if (census.blocks == 0) break;
            const auto x = static_cast<double>(level);
            limited.points.push_back(exactly(x, "", static_cast<double>(census.blocks)));
            limited.points.back().more.emplace_back("nodes", static_cast<double>(census.nodes));
            every.points.push_back(exactly(x, "", static_cast<double>(census.all_slots)));
        }
    }
    result.series = {std::move(limited), std::move(every)};
    return result;
}

}  // namespace scotty::verify
