#include "verify/queues/queues_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <tuple>

#include "verify/capture/failure.h"

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
bool same_value(const std::optional<T>& a, const std::optional<T>& b) {
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

std::string in_words(const ChildVisit& child) {
    std::string text = to_string(child.outcome);
    if (child.position) text += fmt::format(", entry {} there", *child.position);
    if (child.times > 1) text += fmt::format(", {} times", child.times);
    return text;
}

std::string in_words(const reference::HitCandidate& hit) {
    return fmt::format("t {}", exact(hit.t));
}

void compare_children(const Visit& a, const Visit& b, std::vector<PartPair>& parts) {
    const auto in = [](const Visit& visit, std::uint32_t node) -> const ChildVisit* {
        for (const ChildVisit& child : visit.children) {
            if (child.node == node) return &child;
        }
        return nullptr;
    };
    for (const ChildVisit& x : a.children) {
        const ChildVisit* y = in(b, x.node);
        if (y != nullptr && x.outcome == y->outcome && x.times == y->times) continue;
        parts.push_back({fmt::format("child {}", x.node),
                         y == nullptr ? Change::missing : Change::changed, in_words(x),
                         y == nullptr ? "" : in_words(*y)});
    }
    for (const ChildVisit& y : b.children) {
        if (in(a, y.node) != nullptr) continue;
        parts.push_back({fmt::format("child {}", y.node), Change::extra, "", in_words(y)});
    }
}

/// Hits are a set: in which slot one lies is free.
void compare_hits(const LeafVisit& a, const LeafVisit& b, std::vector<PartPair>& parts) {
    std::vector<const GatheredHit*> of_b;
    for (const GatheredHit& hit : b.hits) of_b.push_back(&hit);
    const auto name = [](const GatheredHit& hit) {
        return fmt::format("hit {}", hit.hit.primitive);
    };
    for (const GatheredHit& x : a.hits) {
        const auto same = std::find_if(of_b.begin(), of_b.end(), [&](const GatheredHit* y) {
            return std::memcmp(&x.hit, &y->hit, sizeof x.hit) == 0;
        });
        if (same == of_b.end()) {
            parts.push_back({name(x), Change::missing, in_words(x.hit), ""});
            continue;
        }
        if (x.won != (*same)->won) {
            parts.push_back({name(x), Change::changed, x.won ? "won" : "did not win",
                             (*same)->won ? "won" : "did not win"});
        }
        of_b.erase(same);
    }
    for (const GatheredHit* y : of_b) {
        parts.push_back({name(*y), Change::extra, "", in_words(y->hit)});
    }
}

/// What the visits came to; where in a queue they were is free.
std::vector<PartPair> compare(const Visit& a, const Visit& b) {
    std::vector<PartPair> parts;
    if (!same_value(a.minimum, b.minimum)) {
        const auto words = [](const std::optional<float>& minimum) {
            return minimum ? exact(*minimum) : std::string();
        };
        parts.push_back({"minimum", Change::changed, words(a.minimum), words(b.minimum)});
    }
    compare_children(a, b, parts);
    for (std::size_t c = 0; c < std::min(a.children.size(), b.children.size()); ++c) {
        if (a.children[c].tested && b.children[c].tested) {
            compare_hits(*a.children[c].tested, *b.children[c].tested, parts);
        }
    }
    if (a.leaf_outcome != b.leaf_outcome) {
        parts.push_back(
            {"leaf", Change::changed, to_string(a.leaf_outcome), to_string(b.leaf_outcome)});
    }
    compare_hits(a, b, parts);
    return parts;
}

std::vector<const TraversalHistory*> traversals_of(const RayHistory& history) {
    std::vector<const TraversalHistory*> out;
    for (const BounceHistory& bounce : history.bounces) {
        out.push_back(&bounce.traversal);
        for (const LightHistory& light : bounce.lights) out.push_back(&light.traversal);
    }
    return out;
}

}  // namespace

std::vector<EntryPair> align(const std::vector<Entry>& a, const std::vector<Entry>& b) {
    auto pairs = paired<EntryPair>(a, b, [](const Entry& entry) { return entry.ray; });
    for (EntryPair& pair : pairs) {
        if (!pair.a || !pair.b) continue;
        if (!same_value(pair.a->record, pair.b->record)) pair.what = "ray";
        if (!same_value(pair.a->minimum, pair.b->minimum)) {
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
        pair.parts = compare(*pair.a, *pair.b);
        if (!pair.parts.empty()) {
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

std::vector<TraversalPair> align(const RayHistory& a, const RayHistory& b) {
    static const TraversalHistory nothing;
    std::vector<TraversalPair> out;
    std::vector<const TraversalHistory*> of_b = traversals_of(b);
    for (const TraversalHistory* x : traversals_of(a)) {
        const auto y = std::find_if(of_b.begin(), of_b.end(), [&](const TraversalHistory* other) {
            return other->name == x->name;
        });
        out.push_back({x->name, align(*x, y == of_b.end() ? nothing : **y)});
        if (y != of_b.end()) of_b.erase(y);
    }
    for (const TraversalHistory* y : of_b) out.push_back({y->name, align(nothing, *y)});
    return out;
}

}  // namespace scotty::verify
