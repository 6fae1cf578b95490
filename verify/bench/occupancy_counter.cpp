#include "verify/bench/occupancy_counter.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "reference/base/error.h"
#include "reference/numerics/closest_in_subtree.h"
#include "verify/bench/measure.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records

namespace {

constexpr std::uint32_t kWarp = 32;

std::uint64_t sum_of(std::span<const std::uint32_t> values) {
    return std::accumulate(values.begin(), values.end(), std::uint64_t{0});
}

/// Bytes of one inner node's record.
std::uint64_t node_bytes(const WideBvh& bvh) {
    return std::visit([](const auto& nodes) { return std::uint64_t{sizeof nodes[0]}; }, bvh.inner);
}

/// Where a ray enters a child's box, as the kernels' test has it.
float entry_into(const NodeBoxes& node, std::uint32_t child, const Ray& ray) {
    const RaySlabs slabs = ray_slabs(ray.origin, safe_inverse(ray.direction),
                                     box_pad(ray.origin, node.node_low, node.node_high));
    return clip(intersect_box(slabs, node.low[child], node.high[child]), ray.t_min, ray.t_max)
        .entry;
}

}  // namespace

OccupancyCounter::OccupancyCounter(const WideBvh& bvh, const PipelineParameters& parameters)
    : bvh_(bvh), parameters_(parameters) {
    done_.parameters = parameters;
    done_.bvh_bytes = memory_bytes(bvh);
    done_.triangle_bytes = bvh.triangles.size() * sizeof(LeafTriangle);
}

bool OccupancyCounter::wants(StageKind kind) const {
    return kind == StageKind::intersect_root || kind == StageKind::intersect ||
           kind == StageKind::merge_intersections;
}

void OccupancyCounter::on_stage(const StageView& stage) {
    if (stage.kind == StageKind::merge_intersections) {
        finish(stage);
        return;
    }
    if (stage.level == 0) begin(stage);
    count_level(stage);
}

void OccupancyCounter::on_retry(std::string_view /*stage*/, std::string_view /*reason*/) {
    levels_.clear();  // the root is shown again
}

void OccupancyCounter::begin(const StageView& stage) {
    levels_.clear();
    visits_.clear();
    pushed_ = stage.get(buffers::rays).size();
    leaf_hits_ = 0;
}

void OccupancyCounter::count_level(const StageView& stage) {
    const auto counts = stage.get(buffers::node_counts);
    const std::uint64_t entries = sum_of(counts);
    if (entries != pushed_ || stage.level != levels_.size()) {
        throw Error::internal(
            fmt::format("{}: {} entries in its queues, {} pushed by the level "
                        "before",
                        stage.name, entries, pushed_));
    }
    TraversalCounts& level = levels_.emplace_back();
    level.name = fmt::format("level {}", stage.level);
    level.fill.resize(static_cast<std::size_t>(parameters_.rays_per_block) + 1);
    const std::uint32_t first = bvh_.level_begins[stage.level];
    for (std::uint32_t position = 0; position < counts.size(); ++position) {
        if (counts[position] == 0) continue;
        count_blocks(level, first + position, counts[position]);
        const std::uint32_t ref = bvh_.node_refs[first + position];
        if (is_leaf(ref)) continue;
        if (bvh_.is_level_of_subtrees(stage.level)) {
            walk_subtree(stage, ref_index(ref), position, level);
        } else {
            follow_pushes(stage, ref_index(ref));
        }
    }
    const auto rays = stage.get(buffers::rays);
    if (stage.level == 0) {
        level.dead = static_cast<std::uint64_t>(
            std::count_if(rays.begin(), rays.end(), [](const Ray& ray) { return is_dead(ray); }));
    }
    const bool culls = parameters_.early_out != EarlyOut::off;
    level.visits = entries - level.dead;
    pushed_ = sum_of(stage.get(buffers::child_counts));
    level.traffic.queues = 4 * (pushed_ + (stage.level == 0 ? 0 : entries));
    level.traffic.rays = (sizeof(Ray) + (culls ? 4 : 0)) * entries;
    const std::uint64_t leaf_hits = sum_of(stage.get(buffers::hit_counts));
    level.leaf_hits = leaf_hits - leaf_hits_;
    leaf_hits_ = leaf_hits;
    level.traffic.hits = level.leaf_hits * (culls ? 24 : 16);
    if (parameters_.early_out == EarlyOut::level) level.traffic.hits += 8 * rays.size();
}

void OccupancyCounter::count_blocks(TraversalCounts& level, std::uint32_t node,
                                    std::uint32_t count) const {
    const auto size = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const std::uint32_t full = count / size;
    const std::uint32_t rest = count % size;
    const std::uint32_t blocks = full + (rest != 0 ? 1 : 0);
    level.blocks += blocks;
    level.fill[size] += full;
    if (rest != 0) level.fill[rest] += 1;
    level.warps += full * (size / kWarp) + (rest + kWarp - 1) / kWarp;
    const std::uint32_t ref = bvh_.node_refs[node];
    if (is_leaf(ref)) {
        const Leaf& leaf = bvh_.leaves[ref_index(ref)];
        level.triangle_tests += std::uint64_t{count} * leaf.count;
        level.traffic.triangles += std::uint64_t{blocks} * leaf.count * sizeof(LeafTriangle);
        level.traffic.nodes += std::uint64_t{blocks} * (4 + sizeof(Leaf));
    } else if (!bvh_.ends_queues(node)) {
        const NodeBoxes boxes = boxes_of(bvh_, ref_index(ref));
        level.box_tests += count * static_cast<std::uint64_t>(std::count_if(
                                       boxes.child.begin(), boxes.child.begin() + boxes.width,
                                       [](std::uint32_t child) { return child != kNone; }));
        level.traffic.nodes += blocks * (4 + node_bytes(bvh_));
    } else {
        level.traffic.nodes += std::uint64_t{blocks} * 4;
    }
}

void OccupancyCounter::follow_pushes(const StageView& stage, std::uint32_t inner) {
    const auto rays = stage.get(buffers::rays);
    const auto counts = stage.get(buffers::child_counts);
    const auto offsets = stage.get(buffers::child_offsets);
    const auto queue = stage.get(buffers::child_queue);
    const NodeBoxes boxes = boxes_of(bvh_, inner);
    for (std::uint32_t c = 0; c < boxes.width; ++c) {
        if (boxes.child[c] == kNone) continue;
        const std::uint32_t target = boxes.child[c] - bvh_.level_begins[stage.level + 1];
        for (const std::uint32_t ray : queue.subspan(offsets[target], counts[target])) {
            visits_.push_back({ray, stage.level + 1, entry_into(boxes, c, rays[ray])});
        }
    }
}

void OccupancyCounter::walk_subtree(const StageView& stage, std::uint32_t inner,
                                    std::uint32_t position, TraversalCounts& level) const {
    const auto rays = stage.get(buffers::rays);
    const auto queue = stage.get(buffers::queue);
    const auto minimum = stage.get(buffers::minimum);
    const std::uint32_t begin = stage.get(buffers::queue_offsets)[position];
    const std::uint32_t count = stage.get(buffers::node_counts)[position];
    const bool any = !minimum.empty() && stage.light != kNotApplicable &&
                     parameters_.shadow_query == ShadowQuery::any;
    const auto walk = [&]<int Width>(const std::vector<WideNode<Width>>& /*nodes*/) {
        constexpr std::uint64_t kBoxes = Width * 6 * sizeof(float);
        for (std::uint32_t p = 0; p < count; ++p) {
            const std::uint32_t ray = queue.empty() ? p : queue[begin + p];
            const SubtreeSearch search =
                closest_in_subtree(view_of<Width>(bvh_), inner, rays[ray],
                                   minimum.empty() ? kInfinity : minimum[ray], any);
            level.box_tests += std::uint64_t{search.nodes} * Width;
            level.triangle_tests += search.triangles;
            level.traffic.triangles += search.triangles * sizeof(LeafTriangle);
            level.traffic.nodes +=
                search.nodes * kBoxes + search.children * 4ull + 2 * sizeof(Vec3);
        }
    };
    std::visit(walk, bvh_.inner);
}

void OccupancyCounter::finish(const StageView& stage) {
    const auto rays = stage.get(buffers::rays);
    const auto merged = stage.get(buffers::merged);
    const std::string kind = kind_of_rays(stage);
    for (const VisitEntry& visit : visits_) {
        if (visit.entry > merged[visit.ray].t) levels_[visit.level].redundant += 1;
    }
    TraversalCounts whole;
    whole.name = kind;
    for (const TraversalCounts& level : levels_) {
        whole.add(level);
        row_of(done_.levels, level.name).add(level);
    }
    whole.rays = rays.size() - whole.dead;
    whole.hits = static_cast<std::uint64_t>(
        std::count_if(merged.begin(), merged.end(), [](const Hit& hit) { return is_hit(hit); }));
    whole.traffic.hits += 20 * rays.size() + 8 * whole.leaf_hits + 80 * whole.hits;
    row_of(done_.kinds, kind).add(whole);
    done_.rays_in_flight = std::max<std::uint64_t>(done_.rays_in_flight, rays.size());
    levels_.clear();
}

Occupancy OccupancyCounter::result() const {
    Occupancy out = done_;
    out.all.name = "all";
    for (const TraversalCounts& kind : out.kinds) out.all.add(kind);
    return out;
}

}  // namespace scotty::verify
