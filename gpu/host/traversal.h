/// The host side of one breadth-first traversal on the device.
///
/// All launches of a traversal are queued without waiting: block counts stay on the device, queue
/// capacity is checked there, and the host looks at the fault flags once, at the end.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <span>

#include "gpu/host/device_memory.h"
#include "gpu/host/device_scene.h"
#include "gpu/host/launch_log.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect_subtrees.h"
#include "gpu/kernels/views.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_inputs.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Blocks of a launch, by kernel.
struct LevelBlocks {
    std::uint32_t queues;
    std::uint32_t subtrees;
    std::uint32_t pairs;
    std::uint32_t pair_subtrees;
};

/// Rays in device memory.
struct TracedRays {
    const reference::Ray* rays = nullptr;
    std::uint32_t count = 0;
    reference::TraversalKind kind = reference::TraversalKind::closest;
    bool coherent = false;  ///< those side by side go much the same way: what is fast, no more
};

class Traversal {
 public:
    Traversal(const DeviceScene& scene, const reference::PipelineParameters& parameters,
              MemoryBudget& budget, LaunchLog& log, cudaStream_t stream);

    /// One hit per ray into `hits.merged`, in device memory; where is_one_launch() says so, the
    /// potential of rays without one may be added to the radiance instead. Grows queues and hit
    /// buffers and runs again until nothing was too small. Throws OutOfDeviceMemory where it cannot
    /// grow.
    void run(const TracedRays& traced, const reference::StagePlace& place, const FinalHits& hits);

    /// Queues one traversal without looking at its faults: what is timed, after run() has sized
    /// the buffers for the same rays.
    void enqueue(const TracedRays& traced, const reference::StagePlace& place,
                 const FinalHits& hits);

    /// One stage of a traversal alone, as reference::PipelineInterface::run_stage; shown to the
    /// log's observer. Rays and merged hits live in the memory that is handed in.
    void run_stage(const reference::StageView& stage, DeviceMemory<reference::Ray>& rays,
                   DeviceMemory<reference::Hit>& merged);

    /// Without queues a ray's hit is final when its launch ends: nothing is buffered, and what
    /// nobody looks at is neither merged nor resolved in a launch of its own.
    bool is_one_launch() const { return !log_.observed() && scene_.is_level_of_subtrees(0); }

    void release();

 private:
    void prepare_levels();
    void prepare_rays(std::uint32_t count);
    void clear(const reference::StagePlace& place);
    void load_scan(const reference::StageView& stage);
    void load_level(const reference::StageView& stage);
    void load_minimum(const reference::StageView& stage);
    void load_hits(const reference::StageView& stage);
    void launch_scan(const reference::StagePlace& place, const LevelView& level);
    /// False, and the level not shown, where something was too small. Only an observed traversal
    /// looks; one that is not finds out at its end.
    bool launch_level(const reference::StagePlace& place);
    void launch_kernel(const reference::StagePlace& place, const LevelView& level);
    bool overflowed() const;
    void launch_publish(const reference::StagePlace& place);
    void launch_merge(const reference::StagePlace& place, reference::Hit* merged);
    template <int Width>
    void launch_intersect(const reference::StagePlace& place, const LevelView& level);
    template <int Width>
    void launch_pairs(const reference::StagePlace& place, const LevelView& level);
    void load_pairs(const reference::StageView& stage);
    /// Entries of the level's queues.
    bool is_empty(std::uint32_t level) const;
    /// Names stage, node and sizes.
    reference::Error overflow_of(std::uint32_t node, const reference::StagePlace& place) const;
    /// True when something grew and the traversal has to run again.
    bool grow(const reference::StagePlace& place);
    void show_scan(const reference::StagePlace& place);
    void show_level(const reference::StagePlace& place);
    /// The launch just made, to an observer that wants it. Of a level kernel the blocks are those
    /// that its queues come in, not `blocks`.
    void show(reference::StageKind kind, const reference::StagePlace& place, std::uint32_t blocks,
              std::uint32_t threads, const reference::Hit* merged = nullptr);

    std::uint32_t scan_blocks_of(std::uint32_t level) const;
    LevelView level_view(std::uint32_t level) const;
    PairView pair_view(std::uint32_t level) const;
    bool has_pairs() const { return parameters_.queues == reference::QueueKind::pairs; }
    /// Levels that may have entries: of the lowest one, with leaves only, there are no pairs.
    std::uint32_t levels() const {
        const std::uint32_t all = scene_.level_count();
        return has_pairs() && !scene_.is_level_of_subtrees(all - 1) ? all - 1 : all;
    }
    HitView hit_view() const;
    MinimumView minimum_view() const;
    bool culls() const { return parameters_.early_out != reference::EarlyOut::off; }

    const DeviceScene& scene_;
    const reference::PipelineParameters& parameters_;
    LaunchLog& log_;
    cudaStream_t stream_;
    LevelBlocks level_blocks_;

    const reference::Ray* rays_ = nullptr;
    std::uint32_t count_ = 0;
    reference::TraversalKind kind_ = reference::TraversalKind::closest;
    bool coherent_ = false;
    FinalHits final_hits_;  ///< of a traversal of one launch
    bool alone_ = false;    ///< run_stage(): what a level lowers is shown, too

    std::size_t queue_capacity_ = 0;
    std::uint32_t hit_capacity_;
    DeviceMemory<std::uint32_t> node_counts_;    ///< by node id; with pairs by level
    DeviceMemory<std::uint32_t> queue_offsets_;  ///< by node id + level: levels end with a total
    DeviceMemory<std::uint32_t> block_offsets_;  ///< the same
    /// For scan_counts, by level: a word for the ticket, then one a tile.
    DeviceMemory<std::uint64_t> scans_;
    std::vector<std::size_t> scan_begins_;  ///< by level, in scans_
    DeviceMemory<std::uint32_t> queue_, child_queue_;
    DeviceMemory<reference::NodeRay> pairs_, child_pairs_;
    DeviceMemory<std::uint32_t> hit_counts_;
    DeviceMemory<reference::HitCandidate> candidates_;
    DeviceMemory<std::uint64_t> packed_;
    DeviceMemory<float> minimum_, lowered_;
    DeviceMemory<RayTicket> ray_ticket_;
    DeviceMemory<FaultView> faults_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
