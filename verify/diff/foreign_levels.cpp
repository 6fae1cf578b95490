/// The queues of another program: each level against a back end on the same tree, rays and queues.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <numeric>
#include <utility>

#include "reference/contract/records.h"
#include "verify/diff/foreign_run.h"
#include "verify/diff/judge_box.h"
#include "verify/invariants/expected.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::HitCandidate;
using reference::kNotApplicable;
using reference::OwnedBuffer;
using reference::StageView;

namespace {

using Words = std::vector<std::uint32_t>;
using WordView = std::span<const std::uint32_t>;

/// Queues of a level: counters, places and entries; empty where the capture has none.
struct Queues {
    WordView counts, offsets, entries, given;

    bool has(std::size_t node) const { return node < given.size() && given[node] != 0; }
    WordView of(std::size_t node) const {
        const std::size_t begin = std::min<std::size_t>(offsets[node], entries.size());
        const std::size_t end = std::clamp<std::size_t>(offsets[node + 1], begin, entries.size());
        return entries.subspan(begin, std::min<std::size_t>(end - begin, counts[node]));
    }
};

Queues queues_of(const StageView& stage, bool output) {
    const auto words = [&](const char* in, const char* out) {
        return stage.get<std::uint32_t>(output ? out : in);
    };
    Queues queues{words("node_counts", "child_counts"), words("queue_offsets", "child_offsets"),
                  words("queue", "child_queue"), words("queue_given", "child_queue_given")};
    const bool whole = queues.offsets.size() == queues.counts.size() + 1 &&
                       queues.given.size() == queues.counts.size();
    return whole ? queues : Queues{};
}

Words scanned(const Words& sizes) {
    Words offsets(sizes.size() + 1, 0);
    std::partial_sum(sizes.begin(), sizes.end(), offsets.begin() + 1);
    return offsets;
}

/// One level's launch again, on the queues as they were captured.
class LevelRun {
 public:
    LevelRun(const StageView& stage, const ForeignTree& tree, const ForeignQuery& query,
             const Queues& queues)
        : tree_(tree) {
        const auto& begins = tree.input.bvh.level_begins;
        const std::uint32_t first = begins[stage.level];
        const std::uint32_t children = begins[stage.level + 1];
        view_.name = stage.name;
        view_.kind = stage.kind;
        view_.bounce = stage.bounce;
        view_.light = stage.light;
        view_.level = stage.level;
        Words counts(children - first, 0), queue, leaf_entries(query.count(), 0);
        std::vector<bool> seen(query.count(), false);
        for (std::uint32_t node = 0; node < counts.size(); ++node) {
            if (stage.level == 0) {
                counts[node] = query.count();
                continue;
            }
            if (!queues.has(node)) continue;
            const std::size_t begin = queue.size();
            for (const std::uint32_t ray : queues.of(node)) {
                if (ray >= query.count() || seen[ray]) continue;
                seen[ray] = true;
                queue.push_back(ray);
                if (reference::is_leaf(tree.input.bvh.node_refs[first + node])) ++leaf_entries[ray];
            }
            for (std::size_t i = begin; i < queue.size(); ++i) seen[queue[i]] = false;
            counts[node] = static_cast<std::uint32_t>(queue.size() - begin);
        }
        const std::uint32_t end =
            stage.level + 2 < begins.size() ? begins[stage.level + 2] : children;
        Words room(end - children), blocks;
        for (std::uint32_t child = 0; child < room.size(); ++child) {
            room[child] = counts[tree.input.bvh.parents[children + child] - first];
        }
        const auto threads = static_cast<std::uint32_t>(tree.input.parameters.rays_per_block);
        for (const std::uint32_t count : counts) blocks.push_back((count + threads - 1) / threads);
        slots_ = std::max(1u, *std::max_element(leaf_entries.begin(), leaf_entries.end()));
        const Words no_hits(query.count(), 0);
        const std::vector<HitCandidate> blank(std::size_t{slots_} * query.count(),
                                              {reference::kInfinity, reference::kNone});
        add(buffer_view<reference::Ray>(buffers::rays, query.rays));
        add(buffer_view<std::uint32_t>(buffers::node_counts, counts));
        add(buffer_view<std::uint32_t>(buffers::queue_offsets, scanned(counts)));
        add(buffer_view<std::uint32_t>(buffers::queue, queue));
        add(buffer_view<std::uint32_t>(buffers::block_offsets, scanned(blocks)));
        add(buffer_view<std::uint32_t>(buffers::child_offsets, scanned(room)));
        add(buffer_view<std::uint32_t>(buffers::hit_counts, no_hits));
        add(buffer_view<HitCandidate>(buffers::hits, blank, query.count()));
        child_offsets_ = scanned(room);
    }

    void run(const Backend& backend) {
        for (OwnedBuffer& buffer : backend.pipeline(tree_.input)->run_stage(view_)) {
            outputs_.push_back(std::move(buffer));
            view_.outputs.push_back(outputs_.back().view());
        }
    }
    /// What was pushed to a child, sorted.
    Words pushed(std::uint32_t child) const {
        const auto queue = view_.get(buffers::child_queue);
        const auto counts = view_.get(buffers::child_counts);
        const auto used = queue.subspan(child_offsets_[child], counts[child]);
        Words rays(used.begin(), used.end());
        std::sort(rays.begin(), rays.end());
        return rays;
    }
    void note_hits(ForeignQuery& query) const {
        const auto counts = view_.get(buffers::hit_counts);
        const auto hits = view_.get(buffers::hits);
        for (std::uint32_t ray = 0; ray < counts.size(); ++ray) {
            for (std::uint32_t slot = 0; slot < std::min(counts[ray], slots_); ++slot) {
                query.leaf_hits[ray].push_back(hits[std::size_t{ray} * slots_ + slot]);
            }
        }
    }

 private:
    void add(const reference::BufferView& view) {
        inputs_.push_back(own(view));
        view_.inputs.push_back(inputs_.back().view());
    }

    const ForeignTree& tree_;
    std::deque<OwnedBuffer> inputs_, outputs_;
    StageView view_;
    Words child_offsets_;
    std::uint32_t slots_ = 1;
};

/// One child's queue against what should be in it.
class ChildCheck {
 public:
    ChildCheck(const ForeignTree& tree, const ForeignQuery& query, bool culls,
               ForeignVerdict& verdict)
        : tree_(tree), query_(query), culls_(culls), verdict_(verdict) {}

    /// Of what a queue holds: no ray's ids, and rays that are there twice. Returns the rays,
    /// sorted.
    Words rays_of(const char* buffer, std::uint32_t node, WordView entries, std::size_t claimed) {
        verdict_.judged(buffer);
        if (claimed > entries.size()) {
            verdict_.fail(buffer, node, kNotApplicable,
                          "the queue's counter is beyond its capacity: rays were lost, or written "
                          "over something else",
                          fmt::format("{} rays in {} slots", claimed, entries.size()),
                          "no more than there is room for");
        }
        Words rays;
        for (std::size_t slot = 0; slot < entries.size(); ++slot) {
            if (entries[slot] < query_.count()) {
                rays.push_back(entries[slot]);
                continue;
            }
            verdict_.fail(buffer, node, entries[slot], "an entry of the queue is no ray's id",
                          fmt::format("slot {}", slot), "no such entry");
        }
        std::sort(rays.begin(), rays.end());
        for (std::size_t i = 1; i < rays.size(); ++i) {
            if (rays[i] != rays[i - 1]) continue;
            verdict_.fail(buffer, node, rays[i], "the ray is in the node's queue twice", "twice",
                          "once");
        }
        rays.erase(std::unique(rays.begin(), rays.end()), rays.end());
        return rays;
    }

    /// `parent`: the rays of the parent's queue, sorted. `block_of(ray)`: who pushed it.
    template <class BlockOf>
    void compare(std::uint32_t node, const Words& found, Words expected, const Words& parent,
                 const BlockOf& block_of) {
        Words kept;
        std::set_intersection(expected.begin(), expected.end(), parent.begin(), parent.end(),
                              std::back_inserter(kept));
        Words missing, extra;
        std::set_difference(kept.begin(), kept.end(), found.begin(), found.end(),
                            std::back_inserter(missing));
        std::set_difference(found.begin(), found.end(), kept.begin(), kept.end(),
                            std::back_inserter(extra));
        for (const std::uint32_t ray : missing) judge_missing(node, ray, block_of);
        for (const std::uint32_t ray : extra) {
            if (!std::binary_search(parent.begin(), parent.end(), ray)) {
                verdict_.fail("child_queue", node, ray,
                              "the ray is in the node's queue, but not in its parent's", "the ray",
                              "no such ray");
                continue;
            }
            judge_extra(node, ray, block_of);
        }
    }

 private:
    BoxVerdict box_of(std::uint32_t node, std::uint32_t ray) const {
        const reference::WideBvh& bvh = tree_.input.bvh;
        const NodeBoxes boxes =
            boxes_of(bvh, reference::ref_index(bvh.node_refs[bvh.parents[node]]));
        for (std::uint32_t c = 0; c < boxes.width; ++c) {
            if (boxes.child[c] == node) {
                return judge_box(boxes.low[c], boxes.high[c], query_.rays[ray]);
            }
        }
        return {};
    }
    template <class BlockOf>
    void judge_missing(std::uint32_t node, std::uint32_t ray, const BlockOf& block_of) {
        const BoxVerdict box = box_of(node, ray);
        const reference::Hit& truth = query_.truth[ray];
        const bool behind = is_hit(truth) && (query_.asks_any || box.entry + box.margin >=
                                                                     double{truth.t} * (1 - 1e-5));
        if (culls_ && behind) return;
        if (!query_.sound[ray] || box.verdict != reference::Verdict::hit) {
            return verdict_.excuse("child_queue");
        }
        verdict_.fail("child_queue", node, ray, "the ray is missing from the node's queue",
                      "no such ray",
                      fmt::format("the ray, which enters the node's box at {:.6g}{}", box.entry,
                                  !culls_ || !is_hit(truth)
                                      ? ""
                                      : fmt::format(" and has its closest hit at {:.6g}", truth.t)),
                      block_of(ray));
    }
    template <class BlockOf>
    void judge_extra(std::uint32_t node, std::uint32_t ray, const BlockOf& block_of) {
        if (!query_.sound[ray] || box_of(node, ray).verdict != reference::Verdict::miss) {
            return verdict_.excuse("child_queue");
        }
        verdict_.fail("child_queue", node, ray,
                      "the ray is in the node's queue, whose box it does not enter", "the ray",
                      "no such ray", block_of(ray));
    }

    const ForeignTree& tree_;
    const ForeignQuery& query_;
    bool culls_;
    ForeignVerdict& verdict_;
};

/// The root takes every ray that is traced.
Words judge_root(const Queues& queues, ChildCheck& check, const ForeignQuery& query,
                 ForeignVerdict& verdict) {
    Words all;
    for (std::uint32_t ray = 0; ray < query.count(); ++ray) all.push_back(ray);
    if (!queues.has(0)) return all;
    Words found = check.rays_of("queue", 0, queues.of(0), queues.counts[0]);
    for (const std::uint32_t ray : all) {
        if (is_dead(query.rays[ray]) || std::binary_search(found.begin(), found.end(), ray)) {
            continue;
        }
        verdict.fail("queue", 0, ray, "the ray is missing from the root's queue", "no such ray",
                     "the ray");
    }
    return found;
}

}  // namespace

void judge_foreign_level(const StageView& stage, const ForeignTree& tree, const Backend& backend,
                         bool culls, ForeignQuery& query, ForeignVerdict& verdict) {
    const auto& begins = tree.input.bvh.level_begins;
    if (stage.level + 1 >= begins.size()) return;
    const std::uint32_t first = begins[stage.level];
    const std::uint32_t first_child = begins[stage.level + 1];
    const Queues queues = queues_of(stage, false);
    const Queues children = queues_of(stage, true);
    for (std::uint32_t node = 0; node < queues.given.size(); ++node) {
        query.given[first + node] = queues.has(node);
    }
    LevelRun run(stage, tree, query, queues);
    run.run(backend);
    run.note_hits(query);

    ChildCheck check(tree, query, culls, verdict);
    Words root;
    if (stage.level == 0) root = judge_root(queues, check, query, verdict);
    const auto threads = static_cast<std::uint32_t>(tree.input.parameters.rays_per_block);
    const auto blocks = stage.get(buffers::block_offsets);
    for (std::uint32_t child = 0; child < children.given.size(); ++child) {
        const std::uint32_t node = first_child + child;
        const std::uint32_t parent = tree.input.bvh.parents[node] - first;
        if (!children.has(child) || (stage.level != 0 && !queues.has(parent))) continue;
        const WordView entries = queues.has(parent) ? queues.of(parent) : WordView(root);
        Words of_parent(entries.begin(), entries.end());
        std::sort(of_parent.begin(), of_parent.end());
        const Words found =
            check.rays_of("child_queue", node, children.of(child), children.counts[child]);
        const auto block_of = [&](std::uint32_t ray) {
            if (verdict.has_first()) return kNotApplicable;  // one is shown, and this takes a while
            const auto at = std::find(entries.begin(), entries.end(), ray) - entries.begin();
            return blocks[parent] + static_cast<std::uint32_t>(at) / threads;
        };
        check.compare(node, found, run.pushed(child), of_parent, block_of);
    }
}

}  // namespace scotty::verify
