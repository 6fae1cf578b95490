#include "verify/analysis/analysis_census.h"

#include <algorithm>

#include "reference/contract/records.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::StageKind;

bool QueueCensus::wants(StageKind kind) const {
    return kind == StageKind::scan_counts || kind == StageKind::merge_intersections;
}

void QueueCensus::on_stage(const reference::StageView& stage) {
    if (stage.kind == StageKind::scan_counts) {
        const auto counts = stage.get(buffers::node_counts);
        LevelCensus level;
        level.nodes = counts.size();
        for (const std::uint32_t count : counts) {
            level.entries += count;
            level.blocks += (std::uint64_t{count} + rays_per_block_ - 1) / rays_per_block_;
        }
        if (stage.level == 0) {
            current_ = {};
            slots_a_node_ = level.blocks;  // the root has all rays
        }
        level.all_slots = level.nodes * slots_a_node_;
        current_.levels.push_back(level);
    } else if (stage.kind == StageKind::merge_intersections) {
        const auto rays = stage.get(buffers::rays);
        current_.bounce = stage.bounce;
        current_.light = stage.light;
        current_.rays = static_cast<std::uint64_t>(std::count_if(
            rays.begin(), rays.end(), [](const reference::Ray& ray) { return !is_dead(ray); }));
        queries_.push_back(std::move(current_));
        current_ = {};
    }
}

void QueueCensus::on_retry(std::string_view /*stage*/, std::string_view /*reason*/) {
    current_ = {};
}

std::uint64_t entries_of(const std::vector<QueryCensus>& queries) {
    std::uint64_t sum = 0;
    for (const QueryCensus& query : queries) {
        for (const LevelCensus& level : query.levels) sum += level.entries;
    }
    return sum;
}

}  // namespace scotty::verify
