/// Queues of two runs side by side, aligned by ray id.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "verify/queues/queues.h"
#include "verify/queues/queues_history.h"

namespace scotty::verify {

enum class Change : std::uint8_t {
    same,
    moved,    ///< at another position of the queue, which the contract leaves free
    changed,  ///< what it carries, or what became of it
    missing,  ///< in B
    extra     ///< in B
};
const char* to_string(Change change);

/// The n-th entry of a ray in A's queue beside the n-th in B's.
struct EntryPair {
    std::optional<Entry> a, b;
    Change change = Change::same;
    std::string what;  ///< of a changed one: the fields
};
/// In A's order; what only B has comes last, in its order.
std::vector<EntryPair> align(const std::vector<Entry>& a, const std::vector<Entry>& b);

struct NodePair {
    NodeRow a, b;
    std::uint64_t moved = 0, changed = 0, missing = 0, extra = 0;
};
/// The same launch of two runs, node by node.
std::vector<NodePair> compare_nodes(const Queues& a, const StageRecord& a_stage, const Queues& b,
                                    const StageRecord& b_stage);

/// What is not the same about a visit: its minimum, a child, the leaf's outcome, a buffered hit.
struct PartPair {
    std::string what;  ///< "minimum", "child 12", "leaf", "hit 311"
    Change change = Change::changed;
    std::string a, b;  ///< in words; empty where that side has none
};
/// One ray's visit of a node in two runs.
struct VisitPair {
    std::optional<Visit> a, b;
    Change change = Change::same;
    std::vector<PartPair> parts;  ///< of a changed one
};
std::vector<VisitPair> align(const TraversalHistory& a, const TraversalHistory& b);

struct TraversalPair {
    std::string name;
    std::vector<VisitPair> visits;
};
/// Traversals by name, in A's order; what only B has comes last.
std::vector<TraversalPair> align(const RayHistory& a, const RayHistory& b);

}  // namespace scotty::verify
