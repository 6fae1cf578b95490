/// The stages of a traversal, run alone.
#include <algorithm>
#include <cmath>

#include "emulation/host/replay_stages.h"
#include "emulation/kernels/intersect.h"
#include "emulation/kernels/intersect_root.h"
#include "emulation/kernels/intersect_subtrees.h"
#include "emulation/kernels/merge_intersections.h"
#include "emulation/kernels/publish_minimum.h"
#include "emulation/kernels/scan_counts.h"

namespace scotty::emulation {

namespace buffers = reference::buffers;

using reference::EarlyOut;
using reference::GatheredHits;
using reference::HitMode;
using reference::LevelInput;
using reference::LevelNodes;
using reference::Ray;
using reference::StageKind;

namespace {

/// An overflow of the hit buffers shows in the counts.
HitView view_of_hits(reference::GatheredHits& hits, HitMode mode, std::uint32_t& needed) {
    return {mode,   hits.capacity, hits.counts.data(), hits.candidates.data(), hits.packed.data(),
            &needed};
}

template <int Width>
void launch_level(ReplayStage& run, std::uint32_t blocks, std::uint32_t grid_side,
                  const LevelInput& in, const LevelView& level, const HitView& hits,
                  const MinimumView& minimum) {
    const reference::WideBvhView<Width> bvh = reference::view_of<Width>(run.bvh);
    const auto threads = static_cast<std::uint32_t>(run.parameters.rays_per_block);
    const auto ray_count = static_cast<std::uint32_t>(in.rays.size());
    const bool subtrees = run.bvh.is_level_of_subtrees(run.stage.level);
    run.device.launch(blocks, threads, [&](const Block& block) {
        if (subtrees) {
            intersect_subtrees(block, bvh, in.rays.data(), level, hits, minimum, grid_side);
        } else if (run.stage.kind == StageKind::intersect_root) {
            intersect_root(block, bvh, in.rays.data(), ray_count, level, minimum);
        } else {
            intersect(block, bvh, in.rays.data(), level, hits, minimum, grid_side);
        }
    });
}

}  // namespace

void replay_scan_counts(ReplayStage& run) {
    const LevelNodes nodes = nodes_of(run.bvh, run.stage);
    const auto counts = run.buffers.input(buffers::node_counts, nodes.count);
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
    run.buffers.output(buffers::block_offsets, block_offsets);
    run.buffers.output(buffers::child_offsets, child_offsets);
}

void replay_intersect(ReplayStage& run) {
    const LevelNodes nodes = nodes_of(run.bvh, run.stage);
    const LevelInput in = level_input(run.buffers, nodes, run.parameters, run.stage);
    const std::size_t n = in.rays.size();
    GatheredHits hits = gathered_hits(run.buffers, run.parameters, n);
    std::uint32_t hits_needed = 0;
    const EarlyOut policy = run.parameters.early_out;
    std::vector<float> minimum, lowered;
    if (policy != EarlyOut::off) minimum = run.buffers.copy(buffers::minimum, n);
    if (policy == EarlyOut::level) lowered = run.buffers.copy(buffers::lowered, n);
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
    const HitView hit_view = view_of_hits(hits, run.parameters.hit_mode, hits_needed);
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
    run.buffers.output(buffers::child_counts, child_counts);
    run.buffers.output(buffers::child_queue, child_queue);
    if (run.parameters.hit_mode == HitMode::packed) {
        run.buffers.output(buffers::packed_hits, hits.packed);
    } else {
        run.buffers.output(buffers::hit_counts, hits.counts);
        run.buffers.output(buffers::hits, hits.candidates);
        run.buffers.shape_last({n, hits.capacity, 2});
    }
    if (policy == EarlyOut::level) {
        run.buffers.output(buffers::lowered, lowered);
    } else if (policy == EarlyOut::immediate) {
        run.buffers.output(buffers::minimum, minimum);
    }
}

void replay_publish_minimum(ReplayStage& run) {
    const std::span<const float> lowered = run.buffers.input(buffers::lowered);
    std::vector<float> minimum(lowered.size());
    run.device.launch_per_item(static_cast<std::uint32_t>(lowered.size()), [&](std::uint32_t ray) {
        publish_minimum(ray, lowered.data(), minimum.data());
    });
    run.buffers.output(buffers::minimum, minimum);
}

void replay_merge_intersections(ReplayStage& run) {
    const std::span<const Ray> rays = run.buffers.input(buffers::rays);
    GatheredHits hits = gathered_hits(run.buffers, run.parameters, rays.size());
    std::uint32_t hits_needed = 0;
    const HitView view = view_of_hits(hits, run.parameters.hit_mode, hits_needed);
    std::vector<reference::Hit> merged(rays.size());
    expect_primitives(run.buffers, hits, run.scene.triangle_count);
    run.device.launch_per_item(static_cast<std::uint32_t>(rays.size()), [&](std::uint32_t ray) {
        merge_intersections(ray, run.scene, rays.data(), view, merged.data());
    });
    run.buffers.output(buffers::merged, merged);
}

}  // namespace scotty::emulation
