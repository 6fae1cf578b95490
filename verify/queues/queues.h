/// The queues of a captured run, as someone asks for them: launches, levels, nodes, entries.
///
/// The model behind `scotty queues`; views of it are in queues_view.h, a ray's way through it in
/// queues_history.h, two runs side by side in queues_diff.h. Buffers are read when they are asked
/// for, one launch at a time.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/contract/wide_bvh.h"
#include "verify/capture/canonical.h"
#include "verify/capture/capture.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

/// One launch of a level kernel in numbers.
struct LevelTotals {
    std::uint32_t nodes = 0;
    std::uint32_t with_work = 0;                    ///< nodes whose queue is not empty
    std::uint64_t entries = 0;                      ///< of all queues that the launch reads
    std::uint32_t longest = 0;                      ///< the longest queue
    std::uint32_t longest_node = reference::kNone;  ///< the first that is as long
    std::uint32_t blocks = 0;                       ///< that have rays
    std::uint64_t pushed = 0;                       ///< entries of the next level's queues
};

struct LaunchRow {
    const StageRecord* stage = nullptr;
    std::optional<LevelTotals> totals;  ///< of level kernels whose counts were captured
    std::optional<Verdict> verdict;     ///< against another capture, by hash
    bool missing = false;               ///< in that one
};

struct NodeRow {
    std::uint32_t node = 0;  ///< breadth-first id
    std::uint32_t parent = reference::kNone;
    bool leaf = false;              ///< or a subtree's root: rays are not pushed on
    std::uint32_t count = 0;        ///< entries that there are
    std::uint32_t claimed = 0;      ///< what the counter says: more where the queue overflowed
    std::uint32_t offset = 0;       ///< of its first entry in the buffer
    std::uint32_t first_block = 0;  ///< logical block of the launch
    std::uint32_t blocks = 0;
    std::uint32_t triangles = 0;          ///< of a leaf, 0: no leaf
    std::vector<std::uint32_t> children;  ///< node ids, of an inner node
    std::vector<std::uint32_t> pushed;    ///< entries of each child's queue after the launch
};

/// Where a path came from.
struct Provenance {
    std::uint32_t pixel_x = 0, pixel_y = 0, sample = 0;
};

struct Entry {
    std::uint32_t position = 0;  ///< in the node's queue
    std::uint32_t block = 0;     ///< logical block of the launch
    std::uint32_t thread = 0;    ///< of the block
    std::uint32_t ray = 0;
    std::optional<reference::Ray> record;  ///< none where the id is no ray's
    std::optional<float> minimum;          ///< nearest hit known; none without early-out
    std::optional<Provenance> from;        ///< none where primary_rays was not captured
};

/// Some of a launch's buffers.
struct PartialStage {
    reference::StageView view;
    std::vector<std::shared_ptr<const reference::OwnedBuffer>> kept;  ///< what the view points into

    template <class T>
    std::span<const T> get(const reference::Buffer<T>& buffer) const {
        return view.get(buffer);
    }
};

/// The queues that one launch reads. Those of a queue of pairs are its runs: sorted by node, then
/// by ray, each node's entries are neighbours.
struct LevelQueues {
    PartialStage stage;
    std::uint32_t first_node = 0;
    Regions regions;                       ///< by position in the level
    std::span<const std::uint32_t> queue;  ///< empty at the root, which takes ray p as entry p
    std::span<const std::uint32_t> block_offsets;
    std::span<const std::uint32_t> places;  ///< of pairs: by entry, its index in the level's queue

    std::uint32_t nodes() const { return static_cast<std::uint32_t>(regions.regions.size()); }
    /// Entry p of the node at that position in the level.
    std::uint32_t ray(std::size_t position, std::size_t p) const {
        return queue.empty() ? static_cast<std::uint32_t>(p)
                             : queue[regions.regions[position].begin + p];
    }
    std::uint32_t block(std::size_t position, std::size_t p) const {
        if (!places.empty()) {
            return places[regions.regions[position].begin + p] / stage.view.threads;
        }
        return block_offsets[position] + static_cast<std::uint32_t>(p) / stage.view.threads;
    }
    std::uint32_t thread(std::size_t position, std::size_t p) const {
        const std::size_t at = places.empty() ? p : places[regions.regions[position].begin + p];
        return static_cast<std::uint32_t>(at % stage.view.threads);
    }
};

class Queues {
 public:
    /// `capture` is borrowed. Reads its scene and BVH; throws bad_input where they are missing, or
    /// where only the index is left.
    explicit Queues(const Capture& capture);

    const Capture& capture() const { return capture_; }
    const reference::WideBvh& bvh() const { return bvh_; }
    const reference::PipelineParameters& parameters() const { return capture_.header().parameters; }
    std::uint32_t batches() const { return batches_; }

    /// Throws bad_input saying what there is.
    const StageRecord& launch(std::uint32_t number) const;
    /// The level of a node; throws bad_input where the tree has no such node.
    std::uint32_t level_of(std::uint32_t node) const;
    /// The node in whose queue rays wait for the triangle: its leaf, or the root of the subtree
    /// that holds its leaf. kNone where the tree has no such primitive.
    std::uint32_t last_queue_of(std::uint32_t primitive) const;

    /// All launches in order. `verdicts`: of the diff with another capture, or null.
    std::vector<LaunchRow> launches(const DiffReport* verdicts = nullptr) const;
    /// The nodes of the level, in order of their ids.
    std::vector<NodeRow> nodes(const StageRecord& stage) const;
    /// A node's queue in its order; throws bad_input where the launch is of another level.
    std::vector<Entry> entries(const StageRecord& stage, std::uint32_t node) const;
    LevelQueues queues_of(const StageRecord& stage) const;

    /// Rays of a batch, by the first launch that has something by ray; 0 where none has.
    std::size_t ray_count(std::uint32_t batch) const;
    /// None where primary_rays was not captured or there is no such ray.
    std::optional<Provenance> origin(std::uint32_t batch, std::uint32_t ray) const;
    /// Ids of all rays of a pixel, by batch; throws bad_input for a pixel outside of the image.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> rays_of(std::uint32_t x,
                                                                 std::uint32_t y) const;

    /// The named buffers; those that the launch has not are left out. Where a level kernel has a
    /// queue of pairs, the buffers of its nodes' queues are what the sorted pairs come to.
    PartialStage some_of(const StageRecord& stage,
                         std::initializer_list<const reference::BufferInfo*> wanted) const;

    bool has_pairs() const { return parameters().queues == reference::QueueKind::pairs; }

 private:
    /// A buffer of the nodes' queues by the pairs that the launch has read or written; null where
    /// it is none of those, or the pairs were not captured.
    std::shared_ptr<const reference::OwnedBuffer> from_pairs(
        const StageRecord& stage, const reference::BufferInfo& wanted) const;
    std::shared_ptr<const reference::OwnedBuffer> buffer(const StageRecord& stage,
                                                         const BufferRecord& record) const;
    std::optional<LevelTotals> totals(const StageRecord& stage) const;
    const PartialStage* primary_rays(std::uint32_t batch) const;

    const Capture& capture_;
    reference::WideBvh bvh_;
    std::vector<std::uint32_t> last_queues_;  ///< by primitive: last_queue_of()
    std::uint32_t batches_ = 0;
    /// What was asked for last comes first: the queue that a launch writes is the next one's.
    mutable std::deque<std::pair<std::string, std::shared_ptr<const reference::OwnedBuffer>>>
        recent_;
    mutable std::vector<std::optional<PartialStage>> origins_;  ///< by batch
};

}  // namespace scotty::verify
