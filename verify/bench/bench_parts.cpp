#include "verify/bench/bench_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "verify/bench/measure.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

using reference::kNotApplicable;
using reference::LaunchRecord;
using reference::StageKind;

namespace {

void add_launch(std::vector<BenchPart>& parts, const std::string& name,
                const LaunchRecord& launch) {
    auto part = std::find_if(parts.begin(), parts.end(),
                             [&](const BenchPart& known) { return known.name == name; });
    if (part == parts.end()) part = parts.insert(part, BenchPart{name});
    part->seconds += launch.seconds;
    part->launches += 1;
    part->blocks += launch.blocks;
    part->items += launch.items;
}

void slowest_first(std::vector<BenchPart>& parts) {
    std::stable_sort(parts.begin(), parts.end(),
                     [](const BenchPart& a, const BenchPart& b) { return a.seconds > b.seconds; });
}

std::string part_rows(const char* heading, const std::vector<BenchPart>& parts, double of,
                      std::size_t most) {
    std::string out = fmt::format("\n{:<34} {:>10} {:>6} {:>9} {:>10} {:>12} {:>10}\n", heading,
                                  "ms", "%", "launches", "blocks", "items", "us/launch");
    for (std::size_t i = 0; i < std::min(most, parts.size()); ++i) {
        const BenchPart& part = parts[i];
        out += fmt::format("{:<34} {:>10.3f} {:>6.1f} {:>9} {:>10} {:>12} {:>10.1f}\n", part.name,
                           1e3 * part.seconds, of > 0.0 ? 100.0 * part.seconds / of : 0.0,
                           part.launches, part.blocks, part.items,
                           1e6 * part.seconds / static_cast<double>(part.launches));
    }
    if (parts.size() > most) out += fmt::format("... {} more in --json\n", parts.size() - most);
    return out;
}

nlohmann::json to_json(const std::vector<BenchPart>& parts) {
    nlohmann::json out = nlohmann::json::array();
    for (const BenchPart& part : parts) {
        out.push_back({{"name", part.name},
                       {"seconds", part.seconds},
                       {"launches", part.launches},
                       {"blocks", part.blocks},
                       {"items", part.items}});
    }
    return out;
}

}  // namespace

std::string kernel_of(const LaunchRecord& launch, const reference::WideBvh& bvh,
                      const reference::PipelineParameters& parameters) {
    if (is_level_kernel(launch.kind) && bvh.is_level_of_subtrees(launch.level)) {
        return "intersect_subtrees";
    }
    if (launch.kind == StageKind::filter) {
        return fmt::format("filter_{}", to_string(parameters.filter));
    }
    return to_string(launch.kind);
}

BenchParts parts_of(const std::vector<LaunchRecord>& launches, const reference::WideBvh& bvh,
                    const reference::PipelineParameters& parameters) {
    BenchParts parts;
    std::vector<BenchPart> shading;
    for (const LaunchRecord& launch : launches) {
        parts.seconds += launch.seconds;
        add_launch(parts.stages, to_string(launch.kind), launch);
        add_launch(parts.kernels, kernel_of(launch, bvh, parameters), launch);
        if (is_level_kernel(launch.kind)) {
            add_launch(parts.levels, fmt::format("level {}", launch.level), launch);
        }
        const std::string kind = kind_of_rays(launch);
        add_launch(kind.empty() ? shading : parts.rays, kind.empty() ? "shading" : kind, launch);
        add_launch(parts.paths,
                   reference::stage_name(launch.kind, 0, launch.bounce, launch.light,
                                         kNotApplicable, false),
                   launch);
    }
    parts.rays.insert(parts.rays.end(), shading.begin(), shading.end());
    slowest_first(parts.stages);
    slowest_first(parts.kernels);
    slowest_first(parts.paths);
    return parts;
}

std::string table(const BenchParts& parts) {
    constexpr std::size_t kAll = 1000;
    constexpr std::size_t kSlowest = 10;
    return part_rows("kernel", parts.kernels, parts.seconds, kAll) +
           part_rows("intersections of", parts.levels, parts.seconds, kAll) +
           part_rows("traversals of", parts.rays, parts.seconds, kAll) +
           part_rows("stage, the slowest", parts.paths, parts.seconds, kSlowest);
}

nlohmann::json to_json(const BenchParts& parts) {
    return {{"stages", to_json(parts.stages)},     {"kernels", to_json(parts.kernels)},
            {"levels", to_json(parts.levels)},     {"traversals", to_json(parts.rays)},
            {"stage_paths", to_json(parts.paths)}, {"kernel_seconds", parts.seconds}};
}

}  // namespace scotty::verify
