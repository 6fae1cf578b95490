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
#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/views.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::reference {

/// Inputs of a stage by name, and the outputs that it collects.
class StageBuffers {
 public:
    explicit StageBuffers(const StageView& stage) : stage_(stage) {}

    /// Throws bad_input naming stage and buffer.
    [[noreturn]] void fail(std::string_view buffer, const std::string& what) const;

    /// An input; throws where it is missing.
    template <class T>
    std::span<const T> input(const Buffer<T>& buffer) const {
        return input<T>(buffer.name);
    }
    /// The same; throws unless it has `count` elements.
    template <class T>
    std::span<const T> input(const Buffer<T>& buffer, std::size_t count) const {
        return input<T>(buffer.name, count);
    }
    /// A copy to work on.
    template <class T>
    std::vector<T> copy(const Buffer<T>& buffer, std::size_t count) const {
        return copy<T>(buffer.name, count);
    }
    /// As buffer_view(): of a hit list `rows` says how many rays share the slots.
    template <class T>
    void output(const Buffer<T>& buffer, const std::type_identity_t<std::vector<T>>& values,
                std::size_t rows = 0) {
        outputs_.push_back(own(buffer_view(buffer, values, rows)));
    }

    // The same by name.
    template <class T>
    std::span<const T> input(std::string_view name) const {
        const BufferView& view = find(name, sizeof(T));
        return {static_cast<const T*>(view.data), view.bytes / sizeof(T)};
    }
    /// The same; throws unless it has `count` elements.
    template <class T>
    std::span<const T> input(std::string_view name, std::size_t count) const {
        const std::span<const T> values = input<T>(name);
        expect_count(name, count, values.size());
        return values;
    }
    /// A copy to work on.
    template <class T>
    std::vector<T> copy(std::string_view name, std::size_t count) const {
        const std::span<const T> values = input<T>(name, count);
        return {values.begin(), values.end()};
    }

    template <class T>
    void output(std::string_view name, const std::vector<T>& values, std::string_view meaning) {
        outputs_.push_back(own(buffer_view(name, std::span<const T>(values), meaning)));
    }
    void shape_last(std::vector<std::size_t> shape) { outputs_.back().shape = std::move(shape); }

    std::vector<OwnedBuffer> take() && { return std::move(outputs_); }

 private:
    const BufferView& find(std::string_view name, std::size_t element_bytes) const;
    void expect_count(std::string_view name, std::size_t expected, std::size_t found) const;

    const StageView& stage_;
    std::vector<OwnedBuffer> outputs_;
};

/// The nodes of a stage's level and of the next, as breadth-first ids.
struct LevelNodes {
    std::uint32_t first = 0, count = 0, first_child = 0, child_count = 0;
};
/// Throws bad_input where the BVH has no such level.
LevelNodes nodes_of(const WideBvh& bvh, const StageView& stage);

/// What a level's kernel reads of queues; at the root `queue_offsets` and `queue` are empty.
struct LevelInput {
    std::span<const Ray> rays;
    std::span<const std::uint32_t> node_counts, queue_offsets, queue, block_offsets, child_offsets;
};
LevelInput level_input(const StageBuffers& buffers, const LevelNodes& nodes,
                       const PipelineParameters& parameters, const StageView& stage);

/// Hits gathered so far, to be added to; `packed` or the other two, after the hit mode.
struct GatheredHits {
    std::vector<std::uint32_t> counts;
    std::vector<HitCandidate> candidates;
    std::vector<std::uint64_t> packed;
    std::uint32_t capacity = 0;  ///< slots a ray
};
GatheredHits gathered_hits(const StageBuffers& buffers, const PipelineParameters& parameters,
                           std::size_t rays);
/// Throws bad_input where a hit's primitive is none of the scene's.
void expect_primitives(const StageBuffers& buffers, const GatheredHits& hits,
                       std::uint32_t triangle_count);
/// The same for merged hits, one a ray.
std::span<const Hit> hits_of_scene(const StageBuffers& buffers, const char* name, std::size_t rays,
                                   std::uint32_t triangle_count);

/// Throws bad_input where the image has no such batch.
BatchView batch_of(const PipelineParameters& parameters, const StageView& stage);

}  // namespace scotty::reference
