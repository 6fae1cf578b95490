/// What a stage is handed when it is run alone, on buffers that came from elsewhere.
///
/// The same for every back end. Everything that indexes something is checked here, because the
/// buffers may come from a broken kernel; what remains for a back end is to launch its kernel.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/views.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::reference {

/// Inputs of a stage by name.
class StageBuffers {
 public:
    explicit StageBuffers(const StageView& stage) : stage_(stage) {}

    /// Throws bad_input naming stage and buffer.
    [[noreturn]] void fail(std::string_view buffer, const std::string& what) const;

    /// An input; throws where it is missing.
    template <class T>
    std::span<const T> input(const Buffer<T>& buffer) const {
        const BufferView& view = find(buffer.name, sizeof(T));
        return {static_cast<const T*>(view.data), view.bytes / sizeof(T)};
    }
    /// The same; throws unless it has `count` elements.
    template <class T>
    std::span<const T> input(const Buffer<T>& buffer, std::size_t count) const {
        const std::span<const T> values = input(buffer);
        expect_count(buffer.name, count, values.size());
        return values;
    }

 private:
    const BufferView& find(std::string_view name, std::size_t element_bytes) const;
    void expect_count(std::string_view name, std::size_t expected, std::size_t found) const;

    const StageView& stage_;
};

/// Whether a stage that is run alone reads the buffer: as an input, or as what it updates.
constexpr bool reads(StageKind kind, const BufferInfo& buffer) {
    for (const StageBuffer& input : stage_info(kind).inputs) {
        if (input.buffer->name == buffer.name) return true;
    }
    for (const StageNeed& need : stage_info(kind).needs) {
        if (need.buffer->name == buffer.name) return true;
    }
    return false;
}

/// Where the stage stands in its render.
StagePlace place_of(const StageView& stage);
/// Whether the first hit of a ray will do, by the stage's place and the parameters.
TraversalKind traversal_kind_of(const StageView& stage, const PipelineParameters& parameters);

/// Keeps what the one stage that is run alone hands back.
class StageOutputs final : public StageObserver {
 public:
    void on_stage(const StageView& stage) override {
        for (const BufferView& output : stage.outputs) outputs_.push_back(own(output));
    }
    std::vector<OwnedBuffer> take() && { return std::move(outputs_); }

 private:
    std::vector<OwnedBuffer> outputs_;
};

/// The nodes of a stage's level and of the next, as breadth-first ids.
struct LevelNodes {
    std::uint32_t first = 0, count = 0, first_child = 0, child_count = 0;
};
/// By WideBvh::level_begins. Throws bad_input where there is no such level.
LevelNodes nodes_of(std::span<const std::uint32_t> level_begins, const StageView& stage);

/// What a level's kernel reads of queues; at the root `queue_offsets` and `queue` are empty.
struct LevelInput {
    std::span<const Ray> rays;
    std::span<const std::uint32_t> node_counts, queue_offsets, queue, block_offsets, child_offsets;
};
LevelInput level_input(const StageBuffers& buffers, const LevelNodes& nodes,
                       const PipelineParameters& parameters, const StageView& stage);

/// The pairs that a level's kernel reads: those of a stage below the root. Throws bad_input where
/// one is no ray's, or of an inner node outside of [first_inner, end_inner), which are the level's.
std::span<const NodeRay> level_pairs(const StageBuffers& buffers, std::size_t rays,
                                     std::uint32_t first_inner, std::uint32_t end_inner);

/// Hits gathered so far; `packed` or the other two, after the hit mode.
struct GatheredHits {
    std::span<const std::uint32_t> counts;
    std::span<const HitCandidate> candidates;
    std::span<const std::uint64_t> packed;
    std::uint32_t capacity = 0;  ///< slots per ray
};
GatheredHits gathered_hits(const StageBuffers& buffers, const PipelineParameters& parameters,
                           std::size_t rays);
/// Throws bad_input where a hit's primitive is none of the scene's.
void expect_primitives(const StageBuffers& buffers, const GatheredHits& hits,
                       std::uint32_t triangle_count);
/// The same for path_hits, one per ray.
std::span<const Hit> path_hits_of_scene(const StageBuffers& buffers, std::size_t rays,
                                        std::uint32_t triangle_count);

/// Throws bad_input where the image has no such batch.
BatchView batch_of(const PipelineParameters& parameters, const StageView& stage);

}  // namespace scotty::reference
