#include "verify/queues/queues_visits.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

namespace scotty::verify {

using reference::kNone;

namespace {

constexpr std::uint32_t kRaysAtOnce = 4096;

bool same_traversal(const StageRecord& a, const StageRecord& b) {
    const bool of_traversal =
        reference::is_of_traversal(a.kind) || a.kind == reference::StageKind::merge_intersections;
    return of_traversal && a.batch == b.batch && a.bounce == b.bounce && a.light == b.light;
}

const TraversalHistory* traversal_of(const RayHistory& history, const StageRecord& stage) {
    const std::size_t bounce = stage.bounce == reference::kNotApplicable ? 0 : stage.bounce;
    if (bounce >= history.bounces.size()) return nullptr;
    const BounceHistory& of = history.bounces[bounce];
    if (stage.light == reference::kNotApplicable) return &of.traversal;
    return stage.light < of.lights.size() ? &of.lights[stage.light].traversal : nullptr;
}

/// By launch: the number of each node's first entry.
std::map<std::uint32_t, std::vector<std::uint32_t>> first_entries(
    const Queues& queues, const std::vector<const StageRecord*>& stages) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> out;
    for (const StageRecord* stage : stages) {
        if (!is_level_kernel(stage->kind)) continue;
        const LevelQueues level = queues.queues_of(*stage);
        std::vector<std::uint32_t>& firsts = out[stage->launch];
        std::uint32_t entry = 0;
        for (const Regions::Region& region : level.regions.regions) {
            firsts.push_back(entry);
            entry += static_cast<std::uint32_t>(region.count);
        }
    }
    return out;
}

}  // namespace

void VisitLog::add(std::uint32_t entry, const Visit& visit, std::uint32_t first_child) {
    One& one = visits_.emplace_back();
    one.entry = entry;
    one.leaf = visit.leaf;
    one.outcome = visit.leaf_outcome;
    one.closest = visit.closest;
    one.hits = visit.hits;
    for (const ChildVisit& child : visit.children) {
        if (child.outcome == Outcome::missed) continue;
        one.met.push_back(child.node - first_child +
                          16 * static_cast<std::uint32_t>(child.outcome));
        one.met_entry.push_back(child.entry.value_or(std::numeric_limits<float>::quiet_NaN()));
    }
}

nlohmann::json VisitLog::arrays(PageArrays& pool, std::size_t entries) const {
    std::vector<const One*> sorted;
    for (const One& one : visits_) sorted.push_back(&one);
    std::sort(sorted.begin(), sorted.end(),
              [](const One* a, const One* b) { return a->entry < b->entry; });
    std::vector<std::uint32_t> did(entries), met, closest_primitive, hits, hit_slot, hit_primitive;
    std::vector<float> met_entry, closest_t, hit_t;
    for (const One* one : sorted) {
        did.at(one->entry) = one->leaf ? static_cast<std::uint32_t>(one->outcome)
                                       : static_cast<std::uint32_t>(one->met.size());
        met.insert(met.end(), one->met.begin(), one->met.end());
        met_entry.insert(met_entry.end(), one->met_entry.begin(), one->met_entry.end());
        if (!one->leaf || one->outcome == LeafOutcome::none) continue;
        closest_t.push_back(one->closest.t);
        closest_primitive.push_back(one->closest.primitive);
        if (one->outcome != LeafOutcome::buffered && one->outcome != LeafOutcome::other) continue;
        hits.push_back(static_cast<std::uint32_t>(one->hits.size()));
        for (const GatheredHit& hit : one->hits) {
            hit_slot.push_back(2 * hit.slot + (hit.won ? 1 : 0));
            hit_t.push_back(hit.hit.t);
            hit_primitive.push_back(hit.hit.primitive);
        }
    }
    return {{"did", pool.add(did)},
            {"met", pool.add(met)},
            {"met_entry", pool.add(met_entry)},
            {"closest_t", pool.add(closest_t)},
            {"closest_primitive", pool.add(closest_primitive)},
            {"hits", pool.add(hits)},
            {"hit_slot", pool.add(hit_slot)},
            {"hit_t", pool.add(hit_t)},
            {"hit_primitive", pool.add(hit_primitive)}};
}

TraversalLog log_traversal(const Queues& queues, const StageRecord& stage) {
    std::vector<const StageRecord*> stages;
    for (const StageRecord& other : queues.capture().stages()) {
        if (same_traversal(other, stage)) stages.push_back(&other);
    }
    const auto firsts = first_entries(queues, stages);
    const auto& bvh = queues.bvh();
    std::vector<std::uint32_t> first_child(bvh.node_count(), kNone);
    for (std::uint32_t node = bvh.node_count(); node-- > 1;) {
        if (bvh.parents[node] < first_child.size()) first_child[bvh.parents[node]] = node;
    }
    TraversalLog log;
    const auto rays = static_cast<std::uint32_t>(queues.ray_count(stage.batch));
    log.winner_node.resize(rays, kNone);
    for (std::uint32_t begin = 0; begin < rays; begin += kRaysAtOnce) {
        std::vector<std::uint32_t> ids(std::min(kRaysAtOnce, rays - begin));
        std::iota(ids.begin(), ids.end(), begin);
        for (const RayHistory& history :
             histories(queues, stage.batch, ids,
                       [&](const StageRecord& other) { return same_traversal(other, stage); })) {
            const TraversalHistory* traversal = traversal_of(history, stage);
            if (traversal == nullptr) continue;
            for (const Visit& visit : traversal->visits) {
                const auto& entries = firsts.at(visit.launch);
                log.launches[visit.launch].add(
                    entries[visit.node - bvh.level_begins[visit.level]] + visit.position, visit,
                    first_child[visit.node]);
            }
            log.winner_node[history.ray] = traversal->winner_node;
            for (const GatheredHit& hit : traversal->stray) {
                log.stray.emplace_back(history.ray, hit);
            }
            log.gaps = traversal->gaps;
        }
    }
    return log;
}

}  // namespace scotty::verify
