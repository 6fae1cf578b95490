#include "emulation/host/traversal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "emulation/kernels/intersect.h"
#include "emulation/kernels/intersect_pairs.h"
#include "emulation/kernels/intersect_root.h"
#include "emulation/kernels/intersect_subtrees.h"
#include "emulation/kernels/merge_intersections.h"
#include "emulation/kernels/publish_minimum.h"
#include "emulation/kernels/scan_counts.h"

namespace scotty::emulation {

namespace buffers = reference::buffers;
using reference::buffer_view;
using reference::EarlyOut;
using reference::HitMode;
using reference::StageKind;
using reference::StageView;

namespace {

/// Calls `launch` for the tree's width, which validation has seen.
template <class Launch>
void at_width(int width, const Launch& launch) {
    switch (width) {
        case 2:
            return launch.template operator()<2>();
        case 4:
            return launch.template operator()<4>();
        case 8:
            return launch.template operator()<8>();
        default:
            return launch.template operator()<16>();
    }
}

std::uint32_t side_of_grid(std::uint32_t blocks) {
    auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(blocks))));
    return std::max(1u, side);
}

StageKind level_stage(const StagePlace& place) {
    return place.level == 0 ? StageKind::intersect_root : StageKind::intersect;
}

}  // namespace

Traversal::Traversal(const reference::Scene& scene, const reference::WideBvh& bvh,
                     const reference::PipelineParameters& parameters, Device& device,
                     LaunchLog& log, const TraversalLimits& limits)
    : scene_(scene),
      bvh_(bvh),
      parameters_(parameters),
      device_(device),
      log_(log),
      limits_(limits),
      parent_positions_(bvh.node_count(), 0),
      hit_capacity_(parameters.hit_capacity) {
    queue_overflow_.resize(1);
    hits_needed_.resize(1);
    for (std::uint32_t level = 1; level < bvh.level_count(); ++level) {
        for (std::uint32_t id = bvh.level_begins[level]; id < bvh.level_begins[level + 1]; ++id) {
            parent_positions_[id] = bvh.parents[id] - bvh.level_begins[level - 1];
        }
    }
}

void Traversal::run(std::span<const reference::Ray> rays, TraversalKind kind, StagePlace place,
                    std::span<reference::Hit> merged) {
    do {
        reset(rays, kind);
        reset_hits(place);
        run_levels(place);
    } while (grow_hits(place));
    merge(place, merged);
}

void Traversal::run_stage(const StageView& stage) {
    const reference::StageBuffers in(stage);
    const StagePlace place = reference::place_of(stage);
    kind_ = reference::traversal_kind_of(stage, parameters_);
    alone_ = true;
    std::vector<reference::Hit> merged;
    switch (stage.kind) {
        case StageKind::scan_counts:
            entries_ = 0;  // counts from elsewhere may be anything, and nothing is indexed by them
            node_counts_.assign(
                in.input(buffers::node_counts, nodes_of(bvh_.level_begins, stage).count));
            scan(place);
            break;
        case StageKind::publish_minimum:
            lowered_.assign(in.input(buffers::lowered));
            minimum_.resize(lowered_.size());
            minimum_.discard();
            publish_minimum(place);
            break;
        case StageKind::merge_intersections:
            rays_ = in.input(buffers::rays);
            load_hits(in, rays_.size());
            expect_primitives(in, gathered_hits(in, parameters_, rays_.size()),
                              view_of(scene_).triangle_count);
            merged.resize(rays_.size());
            merge(place, merged);
            break;
        default:
            load_level(stage);
            launch(place);
            break;
    }
    alone_ = false;
    hit_capacity_ = parameters_.hit_capacity;
}

void Traversal::load_level(const StageView& stage) {
    const reference::StageBuffers in(stage);
    const reference::LevelNodes nodes = nodes_of(bvh_.level_begins, stage);
    if (has_pairs()) {
        rays_ = in.input(buffers::rays);
        entries_ = rays_.size();
        if (stage.level != 0) {
            const std::vector<std::uint32_t> begins = inner_begins(bvh_);
            pairs_.assign(reference::level_pairs(in, rays_.size(), begins[stage.level],
                                                 begins[stage.level + 1]));
            entries_ = pairs_.size();
        }
    } else {
        load_queues(reference::level_input(in, nodes, parameters_, stage), stage.level);
    }
    if (parameters_.early_out != EarlyOut::off) {
        minimum_.assign(in.input(buffers::minimum, rays_.size()));
    }
    if (parameters_.early_out == EarlyOut::level) {
        lowered_.assign(in.input(buffers::lowered, rays_.size()));
    }
    load_hits(in, rays_.size());
}

void Traversal::load_queues(const reference::LevelInput& level, std::uint32_t number) {
    rays_ = level.rays;
    const std::array<std::uint32_t, 2> all{0, static_cast<std::uint32_t>(rays_.size())};
    node_counts_.assign(level.node_counts);
    queue_offsets_.assign(number == 0 ? std::span<const std::uint32_t>(all) : level.queue_offsets);
    queue_.assign(level.queue);
    block_offsets_.assign(level.block_offsets);
    child_offsets_.assign(level.child_offsets);
    entries_ =
        std::accumulate(level.node_counts.begin(), level.node_counts.end(), std::uint64_t{0});
}

void Traversal::load_hits(const reference::StageBuffers& in, std::size_t rays) {
    const reference::GatheredHits hits = reference::gathered_hits(in, parameters_, rays);
    hit_capacity_ = hits.capacity;
    hit_counts_.assign(hits.counts);
    candidates_.assign(hits.candidates);
    packed_.assign(hits.packed);
    queue_overflow_.fill(0);
    hits_needed_.fill(0);
}

void Traversal::reset(std::span<const reference::Ray> rays, TraversalKind kind) {
    rays_ = rays;
    kind_ = kind;
    entries_ = rays.size();
    queue_overflow_.fill(0);
    hits_needed_.fill(0);
    const auto count = static_cast<std::uint32_t>(rays.size());
    node_counts_.resize(1);
    node_counts_.fill(count);
    queue_offsets_.resize(2);
    queue_offsets_.generate([&](std::size_t i) { return i == 0 ? 0 : count; });
    if (parameters_.early_out != EarlyOut::off) {
        minimum_.resize(rays.size());
        // Dead rays included: their t_max of -1 culls them at the root.
        const auto t_max = [&](std::size_t ray) { return rays[ray].t_max; };
        minimum_.generate(t_max);
        if (parameters_.early_out == EarlyOut::level) {
            lowered_.resize(rays.size());
            lowered_.generate(t_max);
        }
    }
}

void Traversal::reset_hits(const StagePlace& place) {
    const std::uint64_t rays = rays_.size();
    if (parameters_.hit_mode == HitMode::packed) {
        packed_.resize(rays);
        packed_.fill(kNoPackedHit);
        return;
    }
    // A capacity that has grown for few rays may be too much for many.
    if (rays * hit_capacity_ > limits_.hit_slots) hit_capacity_ = parameters_.hit_capacity;
    if (rays * hit_capacity_ > limits_.hit_slots) {
        throw reference::Error::bad_input(
            place.name(StageKind::merge_intersections),
            fmt::format("{} rays with {} hit slots each are more than {} slots; trace fewer rays "
                        "at once (--batch-rays, now {}), or lower --hit-capacity",
                        rays, hit_capacity_, limits_.hit_slots, parameters_.batch_rays));
    }
    hit_counts_.resize(rays);
    hit_counts_.fill(0);
    candidates_.resize(rays * hit_capacity_);
    candidates_.discard();
}

void Traversal::run_levels(StagePlace place) {
    for (std::uint32_t level = 0; level < bvh_.level_count() && entries_ > 0; ++level) {
        const StagePlace here = place.at_level(level);
        if (!has_pairs()) scan(here);
        launch(here);
        if (!has_pairs()) check_queues(here);
        if (parameters_.early_out == EarlyOut::level) publish_minimum(here);
        if (has_pairs()) {
            std::swap(pairs_, child_pairs_);
            entries_ = pairs_.size();
            continue;
        }
        std::swap(node_counts_, child_counts_);
        std::swap(queue_offsets_, child_offsets_);
        std::swap(queue_, child_queue_);
        entries_ = std::accumulate(node_counts_.view().begin(), node_counts_.view().end(),
                                   std::uint64_t{0});
    }
}

void Traversal::check_room(StageKind kind, const StagePlace& place) const {
    const std::uint64_t most = entries_ * static_cast<std::uint64_t>(bvh_.width);
    if (most <= limits_.queue_entries) return;
    throw reference::Error::bad_input(
        place.name(kind),
        fmt::format("{} queue entries in {} nodes may need {} slots in the next level, more "
                    "than {}; trace fewer rays at once (--batch-rays, now {})",
                    entries_, level_nodes(place.level), most, limits_.queue_entries,
                    parameters_.batch_rays));
}

void Traversal::scan(const StagePlace& place) {
    const std::uint32_t nodes = level_nodes(place.level);
    const std::uint32_t children = level_nodes(place.level + 1);
    check_room(StageKind::scan_counts, place);
    block_offsets_.resize(nodes + 1);
    child_offsets_.resize(children + 1);
    block_offsets_.discard();
    child_offsets_.discard();
    const ScanView view{
        nodes,
        node_counts_.data(),
        children,
        children == 0 ? nullptr : parent_positions_.data() + bvh_.level_begins[place.level + 1],
        static_cast<std::uint32_t>(parameters_.rays_per_block),
        block_offsets_.data(),
        child_offsets_.data()};
    log_.timed(StageKind::scan_counts, place, 1, nodes, [&] {
        device_.launch(1, kScanThreads, [&](const Block& block) { scan_counts(block, view); });
    });
    show(StageKind::scan_counts, place, 1, kScanThreads);
}

void Traversal::launch(const StagePlace& place) {
    if (has_pairs()) {
        intersect_pair_level(place);
    } else {
        intersect_level(place);
    }
}

void Traversal::intersect_pair_level(const StagePlace& place) {
    const StageKind kind = level_stage(place);
    check_room(kind, place);
    const bool subtrees = bvh_.is_level_of_subtrees(place.level);
    child_pair_count_.resize(1);
    child_pair_count_.fill(0);
    child_pairs_.resize(subtrees ? 0 : entries_ * static_cast<std::uint64_t>(bvh_.width));
    child_pairs_.discard();

    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const auto total = static_cast<std::uint32_t>((entries_ + threads - 1) / threads);
    const bool strided = parameters_.block_order == reference::BlockOrder::strided;
    const std::uint32_t side = strided ? side_of_grid(total) : 0;
    const std::uint32_t blocks = side == 0 ? total : side * side;
    log_.timed(kind, place, blocks, entries_, [&] {
        at_width(bvh_.width, [&]<int Width>() { launch_pairs<Width>(place.level, blocks, side); });
    });
    if (child_pair_count_[0] > child_pairs_.size()) {
        throw reference::Error::internal(
            fmt::format("{}: the next level's queue has {} slots, but {} pairs were appended to it",
                        place.name(kind), child_pairs_.size(), child_pair_count_[0]));
    }
    child_pairs_.resize(child_pair_count_[0]);
    show(kind, place, blocks, threads);
}

template <int Width>
void Traversal::launch_pairs(std::uint32_t level, std::uint32_t blocks, std::uint32_t grid_side) {
    const reference::WideBvhView<Width> bvh = reference::view_of<Width>(bvh_);
    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const PairView queue{static_cast<std::uint32_t>(entries_), level == 0 ? nullptr : pairs_.data(),
                         child_pair_count_.data(), child_pairs_.data()};
    const HitView hits = hit_view();
    const MinimumView minimum = minimum_view();
    const bool subtrees = bvh_.is_level_of_subtrees(level);
    device_.launch(blocks, threads, [&](const Block& block) {
        if (subtrees) {
            intersect_pair_subtrees(block, bvh, rays_.data(), queue, hits, minimum, grid_side);
        } else {
            intersect_pairs(block, bvh, rays_.data(), queue, hits, minimum, grid_side);
        }
    });
}

void Traversal::intersect_level(const StagePlace& place) {
    const std::uint32_t nodes = level_nodes(place.level);
    const std::uint32_t children = level_nodes(place.level + 1);
    child_counts_.resize(children);
    child_counts_.fill(0);
    child_queue_.resize(child_offsets_[children]);
    child_queue_.discard();

    const bool strided = parameters_.block_order == reference::BlockOrder::strided;
    const std::uint32_t total = block_offsets_[nodes];
    const std::uint32_t side = strided && place.level > 0 ? side_of_grid(total) : 0;
    const std::uint32_t blocks = side == 0 ? total : side * side;
    const StageKind kind = level_stage(place);
    log_.timed(kind, place, blocks, entries_, [&] {
        at_width(bvh_.width, [&]<int Width>() { launch_level<Width>(place.level, blocks, side); });
    });
    show(kind, place, blocks, static_cast<std::uint32_t>(parameters_.rays_per_block));
}

template <int Width>
void Traversal::launch_level(std::uint32_t level, std::uint32_t blocks, std::uint32_t grid_side) {
    const reference::WideBvhView<Width> bvh = reference::view_of<Width>(bvh_);
    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const LevelView queues = level_view(level);
    const HitView hits = hit_view();
    const MinimumView minimum = minimum_view();
    const auto ray_count = static_cast<std::uint32_t>(rays_.size());
    const bool subtrees = bvh_.is_level_of_subtrees(level);
    device_.launch(blocks, threads, [&](const Block& block) {
        if (subtrees) {
            intersect_subtrees(block, bvh, rays_.data(), queues, hits, minimum, grid_side);
        } else if (level == 0) {
            intersect_root(block, bvh, rays_.data(), ray_count, queues, minimum);
        } else {
            intersect(block, bvh, rays_.data(), queues, hits, minimum, grid_side);
        }
    });
}

void Traversal::check_queues(const StagePlace& place) {
    if (queue_overflow_[0] == 0) return;
    const std::uint32_t node = queue_overflow_[0] - 1;
    const std::uint32_t child = node - bvh_.level_begins[place.level + 1];
    throw reference::Error::internal(
        fmt::format("{}: the queue of node {} has {} slots, but {} rays were pushed to it",
                    place.name(level_stage(place)), node,
                    child_offsets_[child + 1] - child_offsets_[child], child_counts_[child]));
}

void Traversal::publish_minimum(const StagePlace& place) {
    const auto count = static_cast<std::uint32_t>(lowered_.size());
    log_.timed(StageKind::publish_minimum, place, (count + 255) / 256, count, [&] {
        device_.launch_per_item(count, [&](std::uint32_t ray) {
            emulation::publish_minimum(ray, lowered_.data(), minimum_.data());
        });
    });
    show(StageKind::publish_minimum, place, (count + 255) / 256, 256);
}

bool Traversal::grow_hits(const StagePlace& place) {
    const std::uint32_t needed = hits_needed_[0];
    if (needed == 0) return false;
    const std::uint32_t before = hit_capacity_;
    const std::uint32_t grown = std::max(needed, 2 * before);
    const std::string stage = place.name(StageKind::merge_intersections);
    if (std::uint64_t{grown} * rays_.size() > limits_.hit_slots) {
        throw reference::Error::bad_input(
            stage,
            fmt::format("a ray has {} hits, but {} rays with {} slots each are more than "
                        "{} slots; trace fewer rays at once (--batch-rays, now {}), or "
                        "use --early-out level or --hit-mode packed",
                        needed, rays_.size(), grown, limits_.hit_slots, parameters_.batch_rays));
    }
    hit_capacity_ = grown;
    log_.retry(stage, fmt::format("a ray has {} hits, the buffer had {} slots", needed, before));
    return true;
}

void Traversal::merge(const StagePlace& place, std::span<reference::Hit> merged) {
    const reference::SceneView scene = reference::view_of(scene_);
    const HitView hits = hit_view();
    const auto count = static_cast<std::uint32_t>(rays_.size());
    log_.timed(StageKind::merge_intersections, place, (count + 255) / 256, count, [&] {
        device_.launch_per_item(count, [&](std::uint32_t ray) {
            merge_intersections(ray, scene, rays_.data(), hits, merged.data());
        });
    });
    show(StageKind::merge_intersections, place, (count + 255) / 256, 256, merged);
}

void Traversal::show(StageKind kind, const StagePlace& place, std::uint32_t blocks,
                     std::uint32_t threads, std::span<const reference::Hit> merged) {
    const auto view_of = [&](const reference::BufferInfo& wanted) {
        reference::BufferView shown;
        const auto offer = [&](const auto& buffer, const auto& values, std::size_t rows = 0) {
            if (buffer.name == wanted.name) shown = buffer_view(buffer, values, rows);
        };
        offer(buffers::rays, rays_);
        offer(buffers::node_counts, node_counts_.view());
        offer(buffers::queue_offsets, queue_offsets_.view());
        offer(buffers::queue, queue_.view());
        offer(buffers::block_offsets, block_offsets_.view());
        offer(buffers::child_counts, child_counts_.view());
        offer(buffers::child_offsets, child_offsets_.view());
        offer(buffers::child_queue, child_queue_.view());
        offer(buffers::pairs, pairs_.view());
        offer(buffers::child_pairs, child_pairs_.view());
        offer(buffers::hit_counts, hit_counts_.view());
        offer(buffers::hits, candidates_.view(), rays_.size());
        offer(buffers::packed_hits, packed_.view());
        offer(buffers::minimum, minimum_.view());
        offer(buffers::lowered, lowered_.view());
        offer(buffers::merged, merged);
        return shown;
    };
    log_.show(parameters_, kind, place, blocks, threads, view_of, alone_);
}

LevelView Traversal::level_view(std::uint32_t level) {
    return {bvh_.level_begins[level], level_nodes(level),    bvh_.level_begins[level + 1],
            node_counts_.data(),      queue_offsets_.data(), level == 0 ? nullptr : queue_.data(),
            block_offsets_.data(),    child_counts_.data(),  child_offsets_.data(),
            child_queue_.data(),      queue_overflow_.data()};
}

HitView Traversal::hit_view() {
    return {parameters_.hit_mode, hit_capacity_,  hit_counts_.data(),
            candidates_.data(),   packed_.data(), hits_needed_.data()};
}

MinimumView Traversal::minimum_view() {
    return {parameters_.early_out, kind_ == TraversalKind::any, minimum_.data(),
            parameters_.early_out == EarlyOut::level ? lowered_.data() : minimum_.data()};
}

std::size_t Traversal::device_bytes() const {
    return node_counts_.bytes() + child_counts_.bytes() + queue_offsets_.bytes() +
           child_offsets_.bytes() + block_offsets_.bytes() + queue_.bytes() + child_queue_.bytes() +
           pairs_.bytes() + child_pairs_.bytes() + hit_counts_.bytes() + candidates_.bytes() +
           packed_.bytes() + minimum_.bytes() + lowered_.bytes();
}

}  // namespace scotty::emulation
