/// The host side of one breadth-first traversal: queues, launches, growth.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "emulation/device/device.h"
#include "emulation/device/device_buffer.h"
#include "emulation/host/launch_log.h"
#include "emulation/host/pipeline.h"
#include "emulation/kernels/views.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_inputs.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::emulation {

/// Entries of one buffer at most: offsets are 32-bit, and a message beats a killed process.
struct TraversalLimits {
    std::uint64_t queue_entries = 0xffffffffu;
    std::uint64_t hit_slots = std::uint64_t{1} << 30;
};

/// Traverses batches of rays through one BVH, level by level. Buffers are kept between calls.
class Traversal {
 public:
    Traversal(const reference::Scene& scene, const reference::WideBvh& bvh,
              const reference::PipelineParameters& parameters, Device& device, LaunchLog& log,
              const TraversalLimits& limits = {});

    /// One hit per ray into `merged`. `place` names the stages; its level is set here.
    /// Throws bad_input naming stage and sizes where a queue or hit buffer cannot grow further.
    void run(std::span<const reference::Ray> rays, TraversalKind kind, StagePlace place,
             std::span<reference::Hit> merged);

    /// One stage of a traversal alone, as reference::PipelineInterface::run_stage; shown to the
    /// log's observer.
    void run_stage(const reference::StageView& stage);

    std::size_t device_bytes() const;

 private:
    void load_level(const reference::StageView& stage);
    void load_queues(const reference::LevelInput& level, std::uint32_t number);
    void load_hits(const reference::StageBuffers& in, std::size_t rays);
    void reset(std::span<const reference::Ray> rays, TraversalKind kind);
    void reset_hits(const StagePlace& place);
    void run_levels(StagePlace place);
    /// Throws bad_input naming stage and sizes where the next level's entries may be too many.
    void check_room(reference::StageKind kind, const StagePlace& place) const;
    void scan(const StagePlace& place);
    /// The launch of a level, with whichever queues there are.
    void launch(const StagePlace& place);
    void intersect_pair_level(const StagePlace& place);
    template <int Width>
    void launch_pairs(std::uint32_t level, std::uint32_t blocks, std::uint32_t grid_side);
    void intersect_level(const StagePlace& place);
    template <int Width>
    void launch_level(std::uint32_t level, std::uint32_t blocks, std::uint32_t grid_side);
    void check_queues(const StagePlace& place);
    void publish_minimum(const StagePlace& place);
    bool grow_hits(const StagePlace& place);
    void merge(const StagePlace& place, std::span<reference::Hit> merged);
    /// The launch just made, to an observer that wants it.
    void show(reference::StageKind kind, const StagePlace& place, std::uint32_t blocks,
              std::uint32_t threads, std::span<const reference::Hit> merged = {});

    LevelView level_view(std::uint32_t level);
    bool has_pairs() const { return parameters_.queues == reference::QueueKind::pairs; }
    HitView hit_view();
    MinimumView minimum_view();
    std::uint32_t level_nodes(std::uint32_t level) const {
        return level < bvh_.level_count() ? bvh_.level_begins[level + 1] - bvh_.level_begins[level]
                                          : 0;
    }

    const reference::Scene& scene_;
    const reference::WideBvh& bvh_;
    const reference::PipelineParameters& parameters_;
    Device& device_;
    LaunchLog& log_;
    TraversalLimits limits_;
    std::vector<std::uint32_t> parent_positions_;  ///< by node id: parent's position in its level

    std::span<const reference::Ray> rays_;
    TraversalKind kind_ = TraversalKind::closest;
    std::uint64_t entries_ = 0;  ///< in this level's queues
    bool alone_ = false;         ///< run_stage(): what a level lowers is shown, too

    DeviceBuffer<std::uint32_t> node_counts_{device_, "queue lengths"};
    DeviceBuffer<std::uint32_t> child_counts_{device_, "queue lengths"};
    DeviceBuffer<std::uint32_t> queue_offsets_{device_, "queue offsets"};
    DeviceBuffer<std::uint32_t> child_offsets_{device_, "queue offsets"};
    DeviceBuffer<std::uint32_t> block_offsets_{device_, "block offsets"};
    DeviceBuffer<std::uint32_t> queue_{device_, "ray queues", BufferUse::each_slot_once};
    DeviceBuffer<std::uint32_t> child_queue_{device_, "ray queues", BufferUse::each_slot_once};
    DeviceBuffer<std::uint32_t> child_pair_count_{device_, "number of pairs"};
    DeviceBuffer<reference::NodeRay> pairs_{device_, "pairs", BufferUse::each_slot_once};
    DeviceBuffer<reference::NodeRay> child_pairs_{device_, "pairs", BufferUse::each_slot_once};
    DeviceBuffer<std::uint32_t> queue_overflow_{device_, "the overflow flag"};

    std::uint32_t hit_capacity_;
    DeviceBuffer<std::uint32_t> hits_needed_{device_, "hits needed"};
    DeviceBuffer<std::uint32_t> hit_counts_{device_, "hit counts"};
    DeviceBuffer<reference::HitCandidate> candidates_{device_, "the multi-intersection buffer",
                                                      BufferUse::each_slot_once};
    DeviceBuffer<std::uint64_t> packed_{device_, "packed hits"};
    DeviceBuffer<float> minimum_{device_, "minimum distances"};
    DeviceBuffer<float> lowered_{device_, "lowered distances"};
};

}  // namespace scotty::emulation
