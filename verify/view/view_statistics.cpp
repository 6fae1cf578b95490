#include "verify/view/view_statistics.h"

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "reference/contract/stages.h"

namespace scotty::verify {
namespace {

using reference::kNotApplicable;
using reference::LaunchRecord;
using reference::StageKind;

enum RayKind : std::size_t { kPrimary, kBounce, kShadow, kRayKinds };

RayKind ray_kind_of(const LaunchRecord& launch) {
    if (launch.light != kNotApplicable) return kShadow;
    return launch.bounce == 0 ? kPrimary : kBounce;
}

}  // namespace

nlohmann::json launch_statistics(std::span<const LaunchRecord> launches) {
    std::map<std::string, std::pair<double, std::uint64_t>> stages;
    std::map<std::uint32_t, double> levels;
    std::array<std::uint64_t, kRayKinds> rays{};
    std::array<std::vector<std::uint64_t>, kRayKinds> queues;
    for (const LaunchRecord& launch : launches) {
        auto& [seconds, count] = stages[reference::stage_info(launch.kind).label];
        seconds += launch.seconds;
        ++count;
        if (!reference::is_level_kernel(launch.kind)) continue;
        const std::uint32_t level = launch.level == kNotApplicable ? 0 : launch.level;
        levels[level] += launch.seconds;
        const RayKind kind = ray_kind_of(launch);
        if (launch.kind == StageKind::intersect_root) rays[kind] += launch.items;
        if (queues[kind].size() <= level) queues[kind].resize(level + 1, 0);
        queues[kind][level] += launch.items;
    }
    auto out = nlohmann::json{
        {"stages", nlohmann::json::array()},
        {"levels", nlohmann::json::array()},
        {"queues", queues},
        {"rays",
         {{"primary", rays[kPrimary]}, {"bounce", rays[kBounce]}, {"shadow", rays[kShadow]}}}};
    for (const auto& [label, sums] : stages) {
        out["stages"].push_back({label, sums.first, sums.second});
    }
    for (const auto& [level, seconds] : levels) out["levels"].push_back({level, seconds});
    return out;
}

}  // namespace scotty::verify
