#include "verify/queues_diff.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <tuple>

namespace scotty::verify {

const char* to_string(Change change) {
    switch (change) {
        case Change::same:
            return "same";
        case Change::moved:
            return "moved";
        case Change::changed:
            return "changed";
        case Change::missing:
            return "missing";
        case Change::extra:
            return "extra";
    }
    return "?";
}

namespace {

template <class T>
bool same_bits(const std::optional<T>& a, const std::optional<T>& b) {
    if (a.has_value() != b.has_value()) return false;
    return !a || std::memcmp(&*a, &*b, sizeof(T)) == 0;
}

/// Pairs the n-th of a key in A with the n-th in B, in A's order, and what only B has at the end.
template <class Pair, class T, class Key>
std::vector<Pair> paired(const std::vector<T>& a, const std::vector<T>& b, const Key& key) {
    std::map<std::uint32_t, std::deque<const T*>> of_b;
    for (const T& item : b) of_b[key(item)].push_back(&item);
    std::vector<Pair> out;
    for (const T& item : a) {
        Pair pair;
        pair.a = item;
        const auto found = of_b.find(key(item));
        if (found != of_b.end() && !found->second.empty()) {
            pair.b = *found->second.front();
            found->second.pop_front();
        } else {
            pair.change = Change::missing;
        }
        out.push_back(std::move(pair));
    }
    for (const T& item : b) {
        auto& left = of_b[key(item)];
        if (left.empty() || left.front() != &item) continue;
        left.pop_front();
        Pair pair;
        pair.b = item;
        pair.change = Change::extra;
        out.push_back(std::move(pair));
    }
    return out;
}

bool same_end(const Visit& a, const Visit& b) {
    const auto same_child = [](const ChildVisit& x, const ChildVisit& y) {
        return x.node == y.node && x.outcome == y.outcome && x.times == y.times;
    };
    const auto hits = [](const Visit& visit) {
        std::vector<std::uint64_t> out;
        for (const GatheredHit& hit : visit.hits) {
            std::uint32_t t = 0;
            std::memcpy(&t, &hit.hit.t, sizeof t);
            out.push_back(std::uint64_t{t} << 32 | hit.hit.primitive);
        }
        std::sort(out.begin(), out.end());
        return out;
    };
    return same_bits(a.minimum, b.minimum) && a.leaf_outcome == b.leaf_outcome &&
           hits(a) == hits(b) &&
           std::equal(a.children.begin(), a.children.end(), b.children.begin(), b.children.end(),
                      same_child);
}

}  // namespace

std::vector<EntryPair> align(const std::vector<Entry>& a, const std::vector<Entry>& b) {
    auto pairs = paired<EntryPair>(a, b, [](const Entry& entry) { return entry.ray; });
    for (EntryPair& pair : pairs) {
        if (!pair.a || !pair.b) continue;
        if (!same_bits(pair.a->record, pair.b->record)) pair.what = "ray";
        if (!same_bits(pair.a->minimum, pair.b->minimum)) {
            pair.what += pair.what.empty() ? "minimum" : ", minimum";
        }
        if (!pair.what.empty()) {
            pair.change = Change::changed;
        } else if (pair.a->position != pair.b->position) {
            pair.change = Change::moved;
        }
    }
    return pairs;
}

std::vector<NodePair> compare_nodes(const Queues& a, const StageRecord& a_stage, const Queues& b,
                                    const StageRecord& b_stage) {
    const std::vector<NodeRow> a_rows = a.nodes(a_stage);
    const std::vector<NodeRow> b_rows = b.nodes(b_stage);
    std::vector<NodePair> out;
    for (std::size_t i = 0; i < a_rows.size() && i < b_rows.size(); ++i) {
        NodePair pair{a_rows[i], b_rows[i]};
        if (pair.a.count != 0 || pair.b.count != 0) {
            const auto pairs =
                align(a.entries(a_stage, pair.a.node), b.entries(b_stage, pair.a.node));
            for (const EntryPair& entry : pairs) {
                pair.moved += entry.change == Change::moved ? 1 : 0;
                pair.changed += entry.change == Change::changed ? 1 : 0;
                pair.missing += entry.change == Change::missing ? 1 : 0;
                pair.extra += entry.change == Change::extra ? 1 : 0;
            }
        }
        out.push_back(std::move(pair));
    }
    return out;
}

std::vector<VisitPair> align(const TraversalHistory& a, const TraversalHistory& b) {
    auto pairs =
        paired<VisitPair>(a.visits, b.visits, [](const Visit& visit) { return visit.node; });
    for (VisitPair& pair : pairs) {
        if (!pair.a || !pair.b) continue;
        if (!same_end(*pair.a, *pair.b)) {
            pair.change = Change::changed;
        } else if (pair.a->position != pair.b->position) {
            pair.change = Change::moved;
        }
    }
    // Breadth-first ids: the order of the traversal.
    std::stable_sort(pairs.begin(), pairs.end(), [](const VisitPair& x, const VisitPair& y) {
        return (x.a ? x.a : x.b)->node < (y.a ? y.a : y.b)->node;
    });
    return pairs;
}

}  // namespace scotty::verify
