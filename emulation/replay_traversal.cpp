/// The stages of a traversal, run alone.
#include <algorithm>
#include <cmath>

#include "emulation/intersect.h"
#include "emulation/intersect_root.h"
#include "emulation/merge_intersections.h"
#include "emulation/publish_minimum.h"
#include "emulation/replay_stages.h"
#include "emulation/scan_counts.h"

namespace scotty::emulation {

using reference::EarlyOut;
using reference::HitCandidate;
using reference::HitMode;
using reference::Ray;
using reference::StageKind;

namespace {

/// The nodes of the stage's level and of the next.
struct LevelNodes {
    std::uint32_t first = 0, count = 0, first_child = 0, child_count = 0;
};

LevelNodes nodes_of(const ReplayStage& run) {
    const auto& begins = run.bvh.level_begins;
    const std::uint32_t level = run.stage.level;
    if (level >= run.bvh.level_count()) {
        throw reference::Error::bad_input(
            run.stage.name,
            fmt::format("the BVH has {} levels, so no level {}", run.bvh.level_count(), level));
    }
    const bool last = level + 1 == run.bvh.level_count();
    return {begins[level], begins[level + 1] - begins[level], begins[level + 1],
            last ? 0 : begins[level + 2] - begins[level + 1]};
}

void expect_rising(const ReplayBuffers& buffers, const char* name,
                   std::span<const std::uint32_t> offsets) {
    for (std::size_t i = 1; i < offsets.size(); ++i) {
        if (offsets[i] < offsets[i - 1]) {
            buffers.fail(name, fmt::format("expected offsets that never fall, found {} after {} "
                                           "at element {}",
                                           offsets[i], offsets[i - 1], i));
        }
    }
}

/// What a level's kernel reads of queues. Everything that indexes something is checked: the input
/// may come from a broken kernel.
struct LevelInput {
    std::span<const Ray> rays;
    std::span<const std::uint32_t> node_counts, queue_offsets, queue, block_offsets, child_offsets;
};

LevelInput level_input(const ReplayStage& run, const LevelNodes& nodes) {
    const ReplayBuffers& buffers = run.buffers;
    const auto per_block = static_cast<std::uint32_t>(run.parameters.rays_per_block);
    LevelInput in;
    in.rays = buffers.input<Ray>("rays");
    in.node_counts = buffers.input<std::uint32_t>("node_counts", nodes.count);
    in.block_offsets = buffers.input<std::uint32_t>("block_offsets", nodes.count + 1);
    in.child_offsets = buffers.input<std::uint32_t>("child_offsets", nodes.child_count + 1);
    expect_rising(buffers, "child_offsets", in.child_offsets);
    for (std::uint32_t node = 0; node < nodes.count; ++node) {
        const std::uint64_t blocks =
            (std::uint64_t{in.node_counts[node]} + per_block - 1) / per_block;
        if (std::uint64_t{in.block_offsets[node]} + blocks != in.block_offsets[node + 1]) {
            buffers.fail("block_offsets",
                         fmt::format("node {} of the level has {} rays = {} blocks, but its "
                                     "offsets are {} and {}",
                                     node, in.node_counts[node], blocks, in.block_offsets[node],
                                     in.block_offsets[node + 1]));
        }
    }
    if (run.stage.level == 0) {
        if (in.node_counts[0] != in.rays.size()) {
            buffers.fail("node_counts", fmt::format("expected all {} rays at the root, found {}",
                                                    in.rays.size(), in.node_counts[0]));
        }
        return in;
    }
    in.queue_offsets = buffers.input<std::uint32_t>("queue_offsets", nodes.count + 1);
    in.queue = buffers.input<std::uint32_t>("queue");
    expect_rising(buffers, "queue_offsets", in.queue_offsets);
    for (std::uint32_t node = 0; node < nodes.count; ++node) {
        const std::uint64_t begin = in.queue_offsets[node];
        if (begin + in.node_counts[node] > in.queue.size()) {
            buffers.fail("queue",
                         fmt::format("node {} of the level has entries {} to {}, the "
                                     "buffer has {}",
                                     node, begin, begin + in.node_counts[node], in.queue.size()));
        }
        for (const std::uint32_t ray : in.queue.subspan(begin, in.node_counts[node])) {
            if (ray >= in.rays.size()) {
                buffers.fail("queue", fmt::format("node {} of the level has ray {}, there are {}",
                                                  node, ray, in.rays.size()));
            }
        }
    }
    return in;
}

/// Hits gathered so far, to be added to.
struct HitBuffers {
    std::vector<std::uint32_t> counts;
    std::vector<HitCandidate> candidates;
    std::vector<std::uint64_t> packed;
    std::uint32_t capacity = 0;
    std::uint32_t needed = 0;  ///< an overflow shows in the counts

    HitView view(HitMode mode) {
        return {mode, capacity, counts.data(), candidates.data(), packed.data(), &needed};
    }
};

HitBuffers hit_buffers(const ReplayStage& run, std::size_t rays) {
    HitBuffers hits;
    if (run.parameters.hit_mode == HitMode::packed) {
        hits.packed = run.buffers.copy<std::uint64_t>("packed_hits", rays);
        return hits;
    }
    hits.counts = run.buffers.copy<std::uint32_t>("hit_counts", rays);
    const auto candidates = run.buffers.input<HitCandidate>("hits");
    if (rays == 0 || candidates.size() % rays != 0) {
        run.buffers.fail("hits", fmt::format("expected the same number of slots for each of {} "
                                             "rays, found {} slots",
                                             rays, candidates.size()));
    }
    hits.candidates.assign(candidates.begin(), candidates.end());
    hits.capacity = static_cast<std::uint32_t>(candidates.size() / rays);
    return hits;
}

template <int Width>
void launch_level(ReplayStage& run, std::uint32_t blocks, std::uint32_t grid_side,
                  const LevelInput& in, const LevelView& level, const HitView& hits,
                  const MinimumView& minimum) {
    const reference::WideBvhView<Width> bvh = reference::view_of<Width>(run.bvh);
    const auto threads = static_cast<std::uint32_t>(run.parameters.rays_per_block);
    const auto ray_count = static_cast<std::uint32_t>(in.rays.size());
    run.device.launch(blocks, threads, [&](const Block& block) {
        if (run.stage.kind == StageKind::intersect_root) {
            intersect_root(block, bvh, in.rays.data(), ray_count, level, minimum);
        } else {
            intersect(block, bvh, in.rays.data(), level, hits, minimum, grid_side);
        }
    });
}

}  // namespace

void replay_scan_counts(ReplayStage& run) {
    const LevelNodes nodes = nodes_of(run);
    const auto counts = run.buffers.input<std::uint32_t>("node_counts", nodes.count);
    std::vector<std::uint32_t> parents(nodes.child_count);
    for (std::uint32_t child = 0; child < nodes.child_count; ++child) {
        parents[child] = run.bvh.parents[nodes.first_child + child] - nodes.first;
    }
    std::vector<std::uint32_t> block_offsets(nodes.count + 1);
    std::vector<std::uint32_t> child_offsets(nodes.child_count + 1);
    const ScanView view{nodes.count,
                        counts.data(),
                        nodes.child_count,
                        parents.data(),
                        static_cast<std::uint32_t>(run.parameters.rays_per_block),
                        block_offsets.data(),
                        child_offsets.data()};
    run.device.launch(1, kScanThreads, [&](const Block& block) { scan_counts(block, view); });
    run.buffers.output("block_offsets", block_offsets, "first block by node");
    run.buffers.output("child_offsets", child_offsets, "first queue slot by child node");
}

void replay_intersect(ReplayStage& run) {
    const LevelNodes nodes = nodes_of(run);
    const LevelInput in = level_input(run, nodes);
    const std::size_t n = in.rays.size();
    HitBuffers hits = hit_buffers(run, n);
    const EarlyOut policy = run.parameters.early_out;
    std::vector<float> minimum, lowered;
    if (policy != EarlyOut::off) minimum = run.buffers.copy<float>("minimum", n);
    if (policy == EarlyOut::level) lowered = run.buffers.copy<float>("lowered", n);
    const bool any = run.stage.light != reference::kNotApplicable &&
                     run.parameters.shadow_query == reference::ShadowQuery::any;
    const MinimumView minimum_view{policy, any, minimum.data(),
                                   policy == EarlyOut::level ? lowered.data() : minimum.data()};

    std::vector<std::uint32_t> child_counts(nodes.child_count, 0);
    std::vector<std::uint32_t> child_queue(in.child_offsets.back(), reference::kNone);
    std::uint32_t overflow = 0;  // an overflow shows in the counts
    const LevelView level{nodes.first,
                          nodes.count,
                          nodes.first_child,
                          in.node_counts.data(),
                          in.queue_offsets.data(),
                          run.stage.level == 0 ? nullptr : in.queue.data(),
                          in.block_offsets.data(),
                          child_counts.data(),
                          in.child_offsets.data(),
                          child_queue.data(),
                          &overflow};
    const std::uint32_t total = in.block_offsets.back();
    const bool strided =
        run.parameters.block_order == reference::BlockOrder::strided && run.stage.level > 0;
    const auto side =
        strided ? static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(total)))) : 0u;
    const std::uint32_t blocks = strided ? side * side : total;
    const HitView hit_view = hits.view(run.parameters.hit_mode);
    switch (run.bvh.width) {
        case 2:
            launch_level<2>(run, blocks, side, in, level, hit_view, minimum_view);
            break;
        case 4:
            launch_level<4>(run, blocks, side, in, level, hit_view, minimum_view);
            break;
        case 8:
            launch_level<8>(run, blocks, side, in, level, hit_view, minimum_view);
            break;
        default:
            launch_level<16>(run, blocks, side, in, level, hit_view, minimum_view);
            break;
    }
    run.buffers.output("child_counts", child_counts, "queue length by child");
    run.buffers.output("child_queue", child_queue, "ray ids");
    if (run.parameters.hit_mode == HitMode::packed) {
        run.buffers.output("packed_hits", hits.packed, "t bits << 32 | primitive");
    } else {
        run.buffers.output("hit_counts", hits.counts, "hits gathered by ray");
        run.buffers.output("hits", hits.candidates, "t, primitive");
        run.buffers.shape_last({n, hits.capacity, 2});
    }
    if (policy == EarlyOut::level) {
        run.buffers.output("lowered", lowered, "nearest distance found by ray");
    } else if (policy == EarlyOut::immediate) {
        run.buffers.output("minimum", minimum, "nearest distance that culls");
    }
}

void replay_publish_minimum(ReplayStage& run) {
    const std::span<const float> lowered = run.buffers.input<float>("lowered");
    std::vector<float> minimum(lowered.size());
    run.device.launch_per_item(static_cast<std::uint32_t>(lowered.size()), [&](std::uint32_t ray) {
        publish_minimum(ray, lowered.data(), minimum.data());
    });
    run.buffers.output("minimum", minimum, "nearest distance that the next level reads");
}

void replay_merge_intersections(ReplayStage& run) {
    const std::span<const Ray> rays = run.buffers.input<Ray>("rays");
    HitBuffers hits = hit_buffers(run, rays.size());
    const HitView view = hits.view(run.parameters.hit_mode);
    std::vector<reference::Hit> merged(rays.size());
    for (std::uint32_t ray = 0; ray < rays.size(); ++ray) {
        const HitCandidate best = closest_candidate(ray, view);
        if (best.primitive != reference::kNone && best.primitive >= run.scene.triangle_count) {
            run.buffers.fail(view.mode == HitMode::packed ? "packed_hits" : "hits",
                             fmt::format("ray {} hits primitive {}, the scene has {}", ray,
                                         best.primitive, run.scene.triangle_count));
        }
    }
    run.device.launch_per_item(static_cast<std::uint32_t>(rays.size()), [&](std::uint32_t ray) {
        merge_intersections(ray, run.scene, rays.data(), view, merged.data());
    });
    run.buffers.output("merged", merged, "closest hit: t, primitive, u, v");
}

}  // namespace scotty::emulation
