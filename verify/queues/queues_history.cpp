#include "verify/queues/queues_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <unordered_map>

#include "reference/base/error.h"
#include "verify/base/same_bits.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records, stages and kinds

const char* to_string(Outcome outcome) {
    switch (outcome) {
        case Outcome::missed:
            return "missed";
        case Outcome::culled:
            return "culled";
        case Outcome::pushed:
            return "pushed";
        case Outcome::lost:
            return "lost";
        case Outcome::extra:
            return "extra";
        case Outcome::tested:
            return "tested";
    }
    return "?";
}

const char* to_string(LeafOutcome outcome) {
    switch (outcome) {
        case LeafOutcome::none:
            return "no hit";
        case LeafOutcome::beyond:
            return "beyond";
        case LeafOutcome::buffered:
            return "buffered";
        case LeafOutcome::passed:
            return "passed";
        case LeafOutcome::lost:
            return "lost";
        case LeafOutcome::other:
            return "other";
    }
    return "?";
}

bool is_alive(const std::optional<Ray>& ray) { return ray && !is_dead(*ray); }

namespace {

template <class T>
std::optional<T> at(std::span<const T> values, std::size_t index) {
    if (index >= values.size()) return std::nullopt;
    return values[index];
}

class Historian {
 public:
    Historian(const Queues& queues, std::uint32_t batch, const std::vector<std::uint32_t>& rays)
        : queues_(queues), bvh_(queues.bvh()), rays_(rays) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            index_.emplace(rays[i], i);
            RayHistory& history = out_.emplace_back();
            history.batch = batch;
            history.ray = rays[i];
            history.from = queues.origin(batch, rays[i]);
            history.minimum_is_later = queues.parameters().early_out == EarlyOut::immediate;
        }
    }

    void add(const StageRecord& stage) {
        switch (stage.kind) {
            case StageKind::intersect_root:
            case StageKind::intersect:
                add_level(stage);
                break;
            case StageKind::merge_intersections:
                add_merge(stage);
                break;
            case StageKind::direct_light_rays:
            case StageKind::resolve_light:
                add_light(stage);
                break;
            case StageKind::scene_rays:
                add_scene_rays(stage);
                break;
            case StageKind::reconstruct_image:
                add_image(stage);
                break;
            case StageKind::primary_rays:
            case StageKind::scan_counts:
            case StageKind::publish_minimum:
            case StageKind::filter:
                break;
        }
    }

    std::vector<RayHistory> finish() { return std::move(out_); }

 private:
    /// Where a ray of ours is in the queues that a launch has written.
    struct Place {
        std::uint32_t position = 0;  ///< the first one
        std::uint32_t times = 0;
    };
    using Below = std::unordered_map<std::uint64_t, Place>;  ///< by node << 32 | ray

    BounceHistory& bounce_of(RayHistory& history, const StageRecord& stage) {
        const std::uint32_t bounce = stage.bounce == kNotApplicable ? 0 : stage.bounce;
        while (history.bounces.size() <= bounce) {
            BounceHistory& made = history.bounces.emplace_back();
            made.bounce = static_cast<std::uint32_t>(history.bounces.size() - 1);
            made.traversal.bounce = made.bounce;
            made.traversal.name = fmt::format("bounce{}", made.bounce);
        }
        return history.bounces[bounce];
    }
    LightHistory& light_of(RayHistory& history, const StageRecord& stage) {
        BounceHistory& bounce = bounce_of(history, stage);
        while (bounce.lights.size() <= stage.light) {
            LightHistory& made = bounce.lights.emplace_back();
            made.light = static_cast<std::uint32_t>(bounce.lights.size() - 1);
            made.traversal.bounce = bounce.bounce;
            made.traversal.light = made.light;
            made.traversal.name = fmt::format("bounce{}/light{}", bounce.bounce, made.light);
        }
        return bounce.lights[stage.light];
    }
    TraversalHistory& traversal_of(RayHistory& history, const StageRecord& stage) {
        return stage.light == kNotApplicable ? bounce_of(history, stage).traversal
                                             : light_of(history, stage).traversal;
    }

    void add_level(const StageRecord& stage) {
        const LevelQueues level = queues_.queues_of(stage);
        const PartialStage state = queues_.some_of(stage, {&buffers::rays, &buffers::minimum});
        const Below below = find_below(stage);
        note_gaps(stage);
        for (RayHistory& history : out_) {
            TraversalHistory& traversal = traversal_of(history, stage);
            traversal.ray = at(state.get(buffers::rays), history.ray);
        }
        for (std::uint32_t node = 0; node < level.nodes(); ++node) {
            const std::size_t count = level.regions.regions[node].count;
            for (std::size_t p = 0; p < count; ++p) {
                const auto found = index_.find(level.ray(node, p));
                if (found == index_.end()) continue;
                add_visit(out_[found->second], stage, level, state, below, node, p);
            }
        }
        add_hits(stage);
    }

    /// Levels that should lie between the last one seen and this one.
    void note_gaps(const StageRecord& stage) {
        std::uint32_t& next = next_level_[{stage.bounce, stage.light}];
        for (std::uint32_t level = next; level < stage.level; ++level) {
            for (RayHistory& history : out_) {
                traversal_of(history, stage)
                    .gaps.push_back(
                        stage_name(level == 0 ? StageKind::intersect_root : StageKind::intersect,
                                   stage.batch, stage.bounce, stage.light, level,
                                   queues_.capture().header().several_batches));
            }
        }
        next = stage.level + 1;
    }

    void add_visit(RayHistory& history, const StageRecord& stage, const LevelQueues& level,
                   const PartialStage& state, const Below& below, std::uint32_t node,
                   std::size_t p) {
        Visit visit;
        visit.stage = stage.name;
        visit.launch = stage.launch;
        visit.level = stage.level;
        visit.node = level.first_node + node;
        visit.position = static_cast<std::uint32_t>(p);
        visit.block = level.block(node, p);
        visit.thread = level.thread(node, p);
        visit.minimum = at(state.get(buffers::minimum), history.ray);
        const std::uint32_t ref = bvh_.node_refs[visit.node];
        visit.leaf = bvh_.ends_queues(visit.node);
        visit.subtree = visit.leaf && !is_leaf(ref);
        TraversalHistory& traversal = traversal_of(history, stage);
        if (traversal.ray && visit.leaf) {
            visit.closest =
                visit.subtree
                    ? hit_of_subtree(bvh_, ref_index(ref), *traversal.ray, asks_any(stage))
                    : closest_in_leaf(bvh_, bvh_.leaves[ref_index(ref)], *traversal.ray);
        } else if (traversal.ray) {
            add_children(visit, *traversal.ray, history.ray, below);
        }
        traversal.visits.push_back(std::move(visit));
    }

    bool asks_any(const StageRecord& stage) const {
        const auto& p = queues_.capture().header().parameters;
        return stage.light != kNotApplicable && p.early_out != EarlyOut::off &&
               p.shadow_query == ShadowQuery::any;
    }

    static std::uint64_t place_key(std::uint32_t node, std::uint32_t ray) {
        return std::uint64_t{node} << 32 | ray;
    }

    Below find_below(const StageRecord& stage) {
        const PartialStage part = queues_.some_of(
            stage, {&buffers::child_counts, &buffers::child_offsets, &buffers::child_queue});
        Below below;
        const BufferView* queue = part.view.find(buffers::child_queue.name);
        if (queue == nullptr) return below;
        const auto entries = part.get(buffers::child_queue);
        const Regions regions = regions_of(part.view, *queue, true);
        std::uint32_t node = bvh_.level_begins[stage.level + 1];
        for (const Regions::Region& region : regions.regions) {
            for (std::uint32_t p = 0; p < region.count; ++p) {
                const std::uint32_t ray = entries[region.begin + p];
                if (!index_.contains(ray)) continue;
                Place& place = below[place_key(node, ray)];
                if (place.times++ == 0) place.position = p;
            }
            ++node;
        }
        return below;
    }

    void add_children(Visit& visit, const Ray& ray, std::uint32_t id, const Below& below) {
        const NodeBoxes boxes = boxes_of(bvh_, ref_index(bvh_.node_refs[visit.node]));
        const float limit = visit.minimum.value_or(kInfinity);
        const ExpectedChildren expected = queues_.has_pairs()
                                              ? expected_pairs(boxes, boxes_of(bvh_, 0), ray, limit)
                                              : expected_children(boxes, ray, limit);
        for (std::uint32_t c = 0; c < boxes.width; ++c) {
            if (boxes.child[c] == kNone) continue;
            ChildVisit child;
            child.node = boxes.child[c];
            const auto found = below.find(place_key(child.node, id));
            if (found != below.end()) {
                child.position = found->second.position;
                child.times = found->second.times;
            }
            const bool overlaps = (expected.overlapped >> c & 1u) != 0;
            const bool required = (expected.required >> c & 1u) != 0;
            if (overlaps) child.entry = expected.entry[c];
            child.outcome = outcome_of(overlaps, required, child.times);
            const std::uint32_t ref = bvh_.node_refs[child.node];
            if (queues_.has_pairs() && is_leaf(ref) && child.times == 0) {
                test_child(child, bvh_.leaves[ref_index(ref)], ray, overlaps, required);
            }
            visit.children.push_back(child);
        }
    }

    /// Under `immediate` the minimum known is the one that the launch left: a ray farther than that
    /// may still have been pushed, but one nearer must have been.
    Outcome outcome_of(bool overlaps, bool required, std::uint32_t times) const {
        const bool later = queues_.parameters().early_out == EarlyOut::immediate;
        if (times > 1) return Outcome::extra;
        if (times == 1) return required || (overlaps && later) ? Outcome::pushed : Outcome::extra;
        if (required) return Outcome::lost;
        return overlaps ? Outcome::culled : Outcome::missed;
    }

    /// A leaf's hits say whether it was tested where the minimum known is a later one.
    void test_child(ChildVisit& child, const Leaf& leaf, const Ray& ray, bool overlaps,
                    bool required) const {
        child.outcome = required ? Outcome::tested : overlaps ? Outcome::culled : Outcome::missed;
        if (overlaps) child.tested.emplace().closest = closest_in_leaf(bvh_, leaf, ray);
    }

    /// What the launch has buffered for each ray since the level before.
    void add_hits(const StageRecord& stage) {
        const bool packed_mode = queues_.parameters().hit_mode == HitMode::packed;
        const PartialStage counts =
            queues_.some_of(stage, {&buffers::packed_hits, &buffers::hit_counts});
        std::optional<PartialStage> hits;  // large: read only where a ray of ours has new ones
        for (RayHistory& history : out_) {
            const auto key = std::pair(std::pair(stage.bounce, stage.light), history.ray);
            std::vector<GatheredHit> fresh;
            if (packed_mode) {
                const auto word = at(counts.get(buffers::packed_hits), history.ray);
                std::uint64_t& before = packed_.emplace(key, kNoPackedHit).first->second;
                if (word && *word != before) {
                    before = *word;
                    fresh.push_back({0,
                                     {std::bit_cast<float>(static_cast<std::uint32_t>(*word >> 32)),
                                      static_cast<std::uint32_t>(*word)}});
                }
            } else {
                std::uint32_t& before = gathered_[key];
                const auto count = at(counts.get(buffers::hit_counts), history.ray);
                if (count && *count > before) {
                    if (!hits)
                        hits = queues_.some_of(stage, {&buffers::hits, &buffers::hit_counts});
                    fresh = fresh_hits(*hits, history.ray, before, *count);
                    before = *count;
                }
            }
            attach(history, stage, fresh);
        }
    }

    static std::vector<GatheredHit> fresh_hits(const PartialStage& stage, std::uint32_t ray,
                                               std::uint32_t before, std::uint32_t count) {
        std::vector<GatheredHit> out;
        const auto hits = stage.get(buffers::hits);
        const std::size_t rays = stage.get(buffers::hit_counts).size();
        const std::size_t capacity = rays == 0 ? 0 : hits.size() / rays;
        for (std::uint32_t slot = before; slot < count && slot < capacity; ++slot) {
            out.push_back({slot, hits[ray * capacity + slot]});
        }
        return out;
    }

    /// Each hit goes to the leaf of its primitive; then leaves are judged.
    void attach(RayHistory& history, const StageRecord& stage,
                const std::vector<GatheredHit>& fresh) {
        TraversalHistory& traversal = traversal_of(history, stage);
        for (const GatheredHit& hit : fresh) {
            LeafVisit* leaf = nullptr;
            for (Visit& visit : traversal.visits) {
                if (visit.launch != stage.launch) continue;
                const std::uint32_t node = queues_.last_queue_of(hit.hit.primitive);
                if (visit.node == node) leaf = &visit;
                for (ChildVisit& child : visit.children) {
                    if (child.node != node || !child.tested) continue;
                    child.outcome = Outcome::tested;
                    leaf = &*child.tested;
                }
            }
            (leaf == nullptr ? traversal.stray : leaf->hits).push_back(hit);
        }
        for (Visit& visit : traversal.visits) {
            if (visit.launch != stage.launch) continue;
            if (visit.leaf) visit.leaf_outcome = leaf_outcome_of(visit, visit.minimum);
            for (ChildVisit& child : visit.children) {
                if (child.outcome != Outcome::tested) {
                    child.tested.reset();
                } else {
                    child.tested->leaf_outcome = leaf_outcome_of(*child.tested, visit.minimum);
                }
            }
        }
    }

    LeafOutcome leaf_outcome_of(const LeafVisit& visit, std::optional<float> minimum) const {
        if (!visit.hits.empty()) {
            return visit.hits.size() == 1 && same_bits(visit.hits[0].hit, visit.closest)
                       ? LeafOutcome::buffered
                       : LeafOutcome::other;
        }
        if (visit.closest.primitive == kNone) return LeafOutcome::none;
        if (minimum && visit.closest.t > *minimum) return LeafOutcome::beyond;
        return queues_.parameters().hit_mode == HitMode::packed ? LeafOutcome::passed
                                                                : LeafOutcome::lost;
    }

    void add_merge(const StageRecord& stage) {
        const PartialStage part = queues_.some_of(stage, {&buffers::rays, &buffers::merged});
        for (RayHistory& history : out_) {
            TraversalHistory& traversal = traversal_of(history, stage);
            traversal.merge_launch = stage.launch;
            traversal.merged = at(part.get(buffers::merged), history.ray);
            if (!traversal.ray) traversal.ray = at(part.get(buffers::rays), history.ray);
            if (!traversal.merged || !is_hit(*traversal.merged)) continue;
            const auto note = [&](LeafVisit& visit, std::uint32_t node) {
                for (GatheredHit& hit : visit.hits) {
                    if (hit.hit.primitive != traversal.merged->primitive) continue;
                    hit.won = true;
                    traversal.winner_node = node;
                }
            };
            for (Visit& visit : traversal.visits) {
                note(visit, visit.node);
                for (ChildVisit& child : visit.children) {
                    if (child.tested) note(*child.tested, child.node);
                }
            }
        }
    }

    void add_light(const StageRecord& stage) {
        const bool resolve = stage.kind == StageKind::resolve_light;
        const PartialStage part =
            resolve ? queues_.some_of(stage, {&buffers::radiance})
                    : queues_.some_of(stage, {&buffers::shadow_rays, &buffers::potential});
        for (RayHistory& history : out_) {
            LightHistory& light = light_of(history, stage);
            if (resolve) {
                light.radiance = at(part.get(buffers::radiance), history.ray);
            } else {
                light.shadow_ray = at(part.get(buffers::shadow_rays), history.ray);
                light.potential = at(part.get(buffers::potential), history.ray);
            }
        }
    }

    void add_scene_rays(const StageRecord& stage) {
        const PartialStage part = queues_.some_of(
            stage, {&buffers::rays, &buffers::throughput, &buffers::radiance, &buffers::flags});
        for (RayHistory& history : out_) {
            BounceHistory& bounce = bounce_of(history, stage);
            bounce.flags = at(part.get(buffers::flags), history.ray);
            bounce.next = at(part.get(buffers::rays), history.ray);
            bounce.throughput = at(part.get(buffers::throughput), history.ray);
            bounce.radiance = at(part.get(buffers::radiance), history.ray);
        }
    }

    void add_image(const StageRecord& stage) {
        const PartialStage part = queues_.some_of(stage, {&buffers::radiance});
        const auto& stages = queues_.capture().stages();
        const auto last = std::find_if(stages.rbegin(), stages.rend(), [](const StageRecord& s) {
            return s.kind == StageKind::reconstruct_image;
        });
        const PartialStage finished = queues_.some_of(*last, {&buffers::image});
        for (RayHistory& history : out_) {
            history.radiance = at(part.get(buffers::radiance), history.ray);
            if (!history.from) continue;
            history.pixel =
                at(finished.get(buffers::image),
                   std::size_t{history.from->pixel_y} * queues_.parameters().image_width +
                       history.from->pixel_x);
        }
    }

    using Query = std::pair<std::uint32_t, std::uint32_t>;  ///< bounce and light

    const Queues& queues_;
    const WideBvh& bvh_;
    std::vector<std::uint32_t> rays_;
    std::unordered_map<std::uint32_t, std::size_t> index_;
    std::map<Query, std::uint32_t> next_level_;
    std::map<std::pair<Query, std::uint32_t>, std::uint32_t> gathered_;
    std::map<std::pair<Query, std::uint32_t>, std::uint64_t> packed_;
    std::vector<RayHistory> out_;
};

}  // namespace

std::vector<RayHistory> histories(const Queues& queues, std::uint32_t batch,
                                  const std::vector<std::uint32_t>& rays,
                                  const std::function<bool(const StageRecord&)>& wanted) {
    const std::string who = queues.capture().directory().string();
    if (batch >= queues.batches()) {
        throw Error::bad_input(
            who, fmt::format("there is no batch {}; it holds {}", batch, queues.batches()));
    }
    const std::size_t count = queues.ray_count(batch);
    for (const std::uint32_t ray : rays) {
        if (ray < count) continue;
        throw Error::bad_input(who, fmt::format("there is no ray {} in batch {}; it has {} rays, "
                                                "from 0",
                                                ray, batch, count));
    }
    Historian historian(queues, batch, rays);
    for (const StageRecord& stage : queues.capture().stages()) {
        if (stage.batch == batch && (!wanted || wanted(stage))) historian.add(stage);
    }
    return historian.finish();
}

}  // namespace scotty::verify
