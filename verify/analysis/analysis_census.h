/// The content of a render's queues, counted exactly: by query and level, not timed.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/stage_observer.h"

namespace scotty::verify {

struct LevelCensus {
    std::uint64_t nodes = 0;
    std::uint64_t entries = 0;    ///< rays in the queues, once for each queue they are in
    std::uint64_t blocks = 0;     ///< ceil(count / rays per block), over the queues
    std::uint64_t all_slots = 0;  ///< nodes x ceil(rays of the traversal / rays per block)
};

/// One traversal.
struct QueryCensus {
    std::uint32_t bounce = 0;
    std::uint32_t light = reference::kNotApplicable;
    std::uint64_t rays = 0;  ///< living ones
    std::vector<LevelCensus> levels;

    bool primary() const { return bounce == 0 && light == reference::kNotApplicable; }
};

/// The sum over all levels of all queries.
std::uint64_t entries_of(const std::vector<QueryCensus>& queries);

/// Counts when attached to a pipeline. A traversal that is run again counts once.
class QueueCensus : public reference::StageObserver {
 public:
    explicit QueueCensus(std::uint32_t rays_per_block) : rays_per_block_(rays_per_block) {}

    bool wants(reference::StageKind kind) const override;
    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

    const std::vector<QueryCensus>& queries() const { return queries_; }

 private:
    std::uint32_t rays_per_block_;
    std::uint64_t slots_a_node_ = 0;
    QueryCensus current_;
    std::vector<QueryCensus> queries_;
};

}  // namespace scotty::verify
