/// What every ray did in a traversal, as arrays: the histories of all rays, entry by entry.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "verify/pages/page_arrays.h"
#include "verify/queues/queues.h"
#include "verify/queues/queues_history.h"

namespace scotty::verify {

/// The visits of one launch. An entry's number counts through the launch's queues, node by node.
class VisitLog {
 public:
    void add(std::uint32_t entry, const Visit& visit, std::uint32_t first_child);

    /// Arrays by their numbers, in order of the launch's `entries` (of which one with an id that is
    /// no ray's did nothing):
    ///   did           of each entry: children met, or at a leaf its LeafOutcome
    ///   met           of each child met: its place among the children, outcome * 16
    ///   met_entry     where it enters; NaN where it misses the box
    ///   closest_t, closest_primitive   of each leaf entry whose outcome is not `none`
    ///   hits          of each leaf entry whose outcome is `buffered` or `other`
    ///   hit_slot (slot * 2, + 1 where it won), hit_t, hit_primitive   of each of those hits
    nlohmann::json arrays(PageArrays& pool, std::size_t entries) const;

 private:
    struct One {
        std::uint32_t entry = 0;
        bool leaf = false;
        LeafOutcome outcome = LeafOutcome::none;
        reference::HitCandidate closest{};
        std::vector<std::uint32_t> met;
        std::vector<float> met_entry;
        std::vector<GatheredHit> hits;
    };
    std::vector<One> visits_;
};

/// One traversal of all rays of a batch.
struct TraversalLog {
    std::map<std::uint32_t, VisitLog> launches;
    std::vector<std::uint32_t> winner_node;  ///< by ray; kNone where nothing was hit
    std::vector<std::pair<std::uint32_t, GatheredHit>> stray;  ///< ray, hit from no leaf it was in
    std::vector<std::string> gaps;                             ///< launches that were not captured
};
/// Reads the traversal that `stage` is of, some thousand rays at a time.
TraversalLog log_traversal(const Queues& queues, const StageRecord& stage);

}  // namespace scotty::verify
