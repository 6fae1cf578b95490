#include "reference/contract/stage_inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "reference/contract/batch_plan.h"

namespace scotty::reference {

namespace {

void expect_rising(const StageBuffers& buffers, const char* name,
                   std::span<const std::uint32_t> offsets) {
    for (std::size_t i = 1; i < offsets.size(); ++i) {
        if (offsets[i] < offsets[i - 1]) {
            buffers.fail(name, fmt::format("expected offsets that never fall, found {} after {} "
                                           "at element {}",
                                           offsets[i], offsets[i - 1], i));
        }
    }
}

void expect_blocks(const StageBuffers& buffers, const LevelInput& in, std::uint32_t per_block) {
    for (std::size_t node = 0; node < in.node_counts.size(); ++node) {
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
}

void expect_queues(const StageBuffers& buffers, const LevelInput& in) {
    expect_rising(buffers, "queue_offsets", in.queue_offsets);
    for (std::size_t node = 0; node < in.node_counts.size(); ++node) {
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
}

}  // namespace

void StageBuffers::fail(std::string_view buffer, const std::string& what) const {
    throw Error::bad_input(fmt::format("{}: {}", stage_.name, buffer), what);
}

const BufferView& StageBuffers::find(std::string_view name, std::size_t element_bytes) const {
    const auto& inputs = stage_.inputs;
    const auto found = std::find_if(inputs.begin(), inputs.end(),
                                    [&](const BufferView& view) { return view.name == name; });
    if (found == inputs.end()) fail(name, "the stage needs it to be run alone, and it is missing");
    if (found->bytes % element_bytes != 0) {
        fail(name, fmt::format("expected elements of {} bytes, found {} bytes", element_bytes,
                               found->bytes));
    }
    return *found;
}

void StageBuffers::expect_count(std::string_view name, std::size_t expected,
                                std::size_t found) const {
    if (found != expected) {
        fail(name, fmt::format("expected {} elements, found {}", expected, found));
    }
}

StagePlace place_of(const StageView& stage) {
    StagePlace place{stage.batch, false, stage.bounce, stage.light, stage.level};
    place.several_batches = stage.name != place.name(stage.kind);
    return place;
}

TraversalKind traversal_kind_of(const StageView& stage, const PipelineParameters& parameters) {
    const bool any = stage.light != kNotApplicable && parameters.shadow_query == ShadowQuery::any;
    return any ? TraversalKind::any : TraversalKind::closest;
}

LevelNodes nodes_of(std::span<const std::uint32_t> level_begins, const StageView& stage) {
    const std::size_t levels = level_begins.size() - 1;
    const std::uint32_t level = stage.level;
    if (level >= levels) {
        throw Error::bad_input(stage.name,
                               fmt::format("the BVH has {} levels, so no level {}", levels, level));
    }
    const std::uint32_t next = level_begins[level + 1];
    return {level_begins[level], next - level_begins[level], next,
            level + 1 == levels ? 0 : level_begins[level + 2] - next};
}

LevelInput level_input(const StageBuffers& buffers, const LevelNodes& nodes,
                       const PipelineParameters& parameters, const StageView& stage) {
    LevelInput in;
    in.rays = buffers.input(reference::buffers::rays);
    in.node_counts = buffers.input(reference::buffers::node_counts, nodes.count);
    in.block_offsets = buffers.input(reference::buffers::block_offsets, nodes.count + 1);
    in.child_offsets = buffers.input(reference::buffers::child_offsets, nodes.child_count + 1);
    expect_rising(buffers, "child_offsets", in.child_offsets);
    expect_blocks(buffers, in, static_cast<std::uint32_t>(parameters.rays_per_block));
    if (stage.level == 0) {
        if (in.node_counts[0] != in.rays.size()) {
            buffers.fail("node_counts", fmt::format("expected all {} rays at the root, found {}",
                                                    in.rays.size(), in.node_counts[0]));
        }
        return in;
    }
    in.queue_offsets = buffers.input(reference::buffers::queue_offsets, nodes.count + 1);
    in.queue = buffers.input(reference::buffers::queue);
    expect_queues(buffers, in);
    return in;
}

std::span<const NodeRay> level_pairs(const StageBuffers& buffers, std::size_t rays,
                                     std::uint32_t first_inner, std::uint32_t end_inner) {
    const std::span<const NodeRay> pairs = buffers.input(reference::buffers::pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const NodeRay& pair = pairs[i];
        if (pair.ray >= rays) {
            buffers.fail("pairs",
                         fmt::format("pair {} has ray {}, there are {}", i, pair.ray, rays));
        }
        if (pair.node < first_inner || pair.node >= end_inner) {
            buffers.fail("pairs", fmt::format("pair {} has inner node {}, the level has {} to {}",
                                              i, pair.node, first_inner, end_inner));
        }
    }
    return pairs;
}

GatheredHits gathered_hits(const StageBuffers& buffers, const PipelineParameters& parameters,
                           std::size_t rays) {
    GatheredHits hits;
    if (parameters.hit_mode == HitMode::packed) {
        hits.packed = buffers.input(reference::buffers::packed_hits, rays);
        return hits;
    }
    hits.counts = buffers.input(reference::buffers::hit_counts, rays);
    const auto candidates = buffers.input(reference::buffers::hits);
    if (rays == 0 || candidates.size() % rays != 0) {
        buffers.fail("hits", fmt::format("expected the same number of slots for each of {} "
                                         "rays, found {} slots",
                                         rays, candidates.size()));
    }
    hits.candidates = candidates;
    hits.capacity = static_cast<std::uint32_t>(candidates.size() / rays);
    return hits;
}

void expect_primitives(const StageBuffers& buffers, const GatheredHits& hits,
                       std::uint32_t triangle_count) {
    const auto expect = [&](const char* name, std::size_t ray, std::uint32_t primitive) {
        if (primitive == kNone || primitive < triangle_count) return;
        buffers.fail(name, fmt::format("ray {} hits primitive {}, the scene has {}", ray, primitive,
                                       triangle_count));
    };
    for (std::size_t ray = 0; ray < hits.packed.size(); ++ray) {
        expect("packed_hits", ray, static_cast<std::uint32_t>(hits.packed[ray]));
    }
    for (std::size_t ray = 0; ray < hits.counts.size(); ++ray) {
        for (std::uint32_t slot = 0; slot < std::min(hits.counts[ray], hits.capacity); ++slot) {
            expect("hits", ray, hits.candidates[ray * hits.capacity + slot].primitive);
        }
    }
}

std::span<const Hit> path_hits_of_scene(const StageBuffers& buffers, std::size_t rays,
                                        std::uint32_t triangle_count) {
    const std::span<const Hit> hits = buffers.input(reference::buffers::path_hits, rays);
    for (std::size_t ray = 0; ray < hits.size(); ++ray) {
        if (is_hit(hits[ray]) && hits[ray].primitive >= triangle_count) {
            buffers.fail(reference::buffers::path_hits.name,
                         fmt::format("ray {} hits primitive {}, the scene has {}", ray,
                                     hits[ray].primitive, triangle_count));
        }
    }
    return hits;
}

BatchView batch_of(const PipelineParameters& p, const StageView& stage) {
    const BatchPlan plan(p);
    if (stage.batch < plan.size()) return plan[stage.batch];
    throw Error::bad_input(stage.name,
                           fmt::format("an image of {}x{} pixels, {} samples each, has no batch {}",
                                       p.image_width, p.image_height, p.spp, stage.batch));
}

}  // namespace scotty::reference
