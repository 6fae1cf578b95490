/// Counts what bench_occupancy.h is made of, while a pipeline shows its stages.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"
#include "verify/bench/bench_occupancy.h"

namespace scotty::verify {

/// Hits have to be buffered (HitMode::buffer).
/// Throws internal where a level's queues are not what the level before has pushed.
class OccupancyCounter : public reference::StageObserver {
 public:
    /// Both are borrowed.
    OccupancyCounter(const reference::WideBvh& bvh,
                     const reference::PipelineParameters& parameters);

    bool wants(reference::StageKind kind) const override;
    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

    /// Everything but `device_bytes` and `visits_uncut`.
    Occupancy result() const;

 private:
    /// A ray in a queue, and where it enters the queue's node.
    struct VisitEntry {
        std::uint32_t ray = 0, level = 0;
        float entry = 0.0f;
    };

    void begin(const reference::StageView& stage);
    void count_level(const reference::StageView& stage);
    void count_blocks(TraversalCounts& level, std::uint32_t node, std::uint32_t count) const;
    void follow_pushes(const reference::StageView& stage, std::uint32_t inner);
    void walk_subtree(const reference::StageView& stage, std::uint32_t inner,
                      std::uint32_t position, TraversalCounts& level) const;
    void finish(const reference::StageView& stage);

    const reference::WideBvh& bvh_;
    const reference::PipelineParameters& parameters_;
    Occupancy done_;
    // Of the traversal that runs.
    std::vector<TraversalCounts> levels_;
    std::vector<VisitEntry> visits_;
    std::uint64_t pushed_ = 0;     ///< by the level before
    std::uint64_t leaf_hits_ = 0;  ///< up to the level before
};

}  // namespace scotty::verify
