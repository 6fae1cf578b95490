#include "emulation/simt/interleave/explorer.h"

#include <algorithm>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "emulation/simt/interleave/replayer.h"
#include "reference/base/error.h"

namespace scotty::emulation::simt {

namespace {

constexpr std::uint32_t kMostBlocks = 64;

/// Words in which blocks meet: two blocks have touched them in one run, and one has changed them.
class Meetings {
 public:
    void begin_run() { words_.clear(); }
    void note(std::uint32_t block, const Touch& touch) {
        for (std::uint32_t word = touch.first; word <= touch.last; ++word) {
            auto& [touched, changed] = words_[word];
            touched |= std::uint64_t{1} << block;
            if (touch.writes) changed = true;
            if (changed && (touched & (touched - 1)) != 0) meeting_.insert(word);
        }
    }
    bool meets(const Touch& touch) const {
        const auto word = meeting_.lower_bound(touch.first);
        return word != meeting_.end() && *word <= touch.last;
    }
    std::size_t size() const { return meeting_.size(); }

 private:
    std::unordered_map<std::uint32_t, std::pair<std::uint64_t, bool>> words_;  ///< of this run
    std::set<std::uint32_t> meeting_;
};

/// One choice of the current run, and the alternatives left to try in its place.
struct Node {
    std::vector<BlockState> states;
    std::uint32_t before = 0;  ///< the block that ran last
    std::uint32_t chosen = 0;
    std::uint32_t preemptions = 0;  ///< up to and including this choice
    std::set<std::uint32_t> to_try;
    std::set<std::uint32_t> tried;
    std::vector<std::uint32_t> clock;  ///< by block: its last choice (from 1) that precedes it
};

class Search final : public Chooser {
 public:
    explicit Search(const ExploreOptions& options) : options_(options) {}

    void begin(const Launch& launch) override {
        if (launch.blocks > kMostBlocks) {
            throw reference::Error::bad_input("interleaving", "more than 64 blocks");
        }
        launch_ = {launch.kernel, launch.blocks, launch.threads, {}};
        depth_ = 0;
        meetings_.begin_run();
        met_before_ = meetings_.size();
    }
    bool begins_all() const override { return !linear_; }
    bool stops(std::uint32_t block, std::uint32_t, const Touch& touch) override {
        meetings_.note(block, touch);
        return !linear_ && meetings_.meets(touch);
    }
    std::uint32_t choose(const std::vector<BlockState>& blocks, std::uint32_t current) override {
        if (linear_) return next_by_default(blocks, current);
        if (depth_ == path_.size()) {
            path_.emplace_back();
            path_.back().chosen = next_by_default(blocks, current);
            path_.back().tried.insert(path_.back().chosen);
        }
        Node& node = path_[depth_];
        node.states = blocks;
        node.before = current;
        const std::uint32_t so_far = depth_ == 0 ? 0 : path_[depth_ - 1].preemptions;
        const bool preempts = blocks[current].can_run();
        node.preemptions = so_far + (preempts && node.chosen != current ? 1 : 0);
        if (options_.preemptions) {
            for (std::uint32_t block = 0; block < blocks.size(); ++block) {
                const bool allowed =
                    block == current || !preempts || so_far < *options_.preemptions;
                if (blocks[block].can_run() && allowed) node.to_try.insert(block);
            }
        } else {
            find_dependent(depth_);
        }
        return path_[depth_++].chosen;
    }

    /// The first run takes one block after the other, and stops nowhere.
    void end_linear() { linear_ = false; }
    bool met_anew() const { return meetings_.size() != met_before_; }
    std::size_t words() const { return meetings_.size(); }
    void restart() { path_.clear(); }

    /// Goes to the next order to try; false if there is none.
    bool advance() {
        path_.resize(std::min(depth_, path_.size()));
        while (!path_.empty()) {
            Node& node = path_.back();
            const auto left = std::find_if(node.to_try.begin(), node.to_try.end(),
                                           [&](auto b) { return !node.tried.contains(b); });
            if (left != node.to_try.end()) {
                node.chosen = *left;
                node.tried.insert(*left);
                return true;
            }
            path_.pop_back();
        }
        return false;
    }

    /// The finished run, as switches against the default order.
    Interleaving taken() const {
        Interleaving out = launch_;
        for (std::size_t i = 0; i < depth_; ++i) {
            const Node& node = path_[i];
            if (node.chosen == next_by_default(node.states, node.before)) continue;
            const BlockState& before = node.states[node.before];
            out.switches.push_back({node.before, before.over ? 0 : before.accesses, node.chosen});
        }
        return out;
    }

 private:
    /// Each block's next access could have come earlier: before the last dependent access of
    /// another block that does not already precede it. That is where it is to be tried.
    void find_dependent(std::size_t depth) {
        Node& node = path_[depth];
        const auto blocks = static_cast<std::uint32_t>(node.states.size());
        std::vector<std::vector<std::uint32_t>> clocks(blocks,
                                                       std::vector<std::uint32_t>(blocks, 0));
        for (std::size_t i = 0; i < depth; ++i) clocks[path_[i].chosen] = path_[i].clock;
        for (std::uint32_t block = 0; block < blocks; ++block) {
            const BlockState& state = node.states[block];
            if (state.over) continue;
            for (std::size_t i = depth; i-- > 0;) {
                const Node& earlier = path_[i];
                if (earlier.chosen == block) continue;
                if (!dependent(earlier.states[earlier.chosen].next, state.next)) continue;
                if (i + 1 <= clocks[block][earlier.chosen]) break;
                offer(path_[i], block);
                break;
            }
        }
        // The clock of the access that runs now: it follows all dependent accesses so far.
        std::vector<std::uint32_t> clock = clocks[node.chosen];
        for (std::size_t i = 0; i < depth; ++i) {
            const Node& earlier = path_[i];
            if (!dependent(earlier.states[earlier.chosen].next, node.states[node.chosen].next)) {
                continue;
            }
            for (std::uint32_t b = 0; b < blocks; ++b) {
                clock[b] = std::max(clock[b], earlier.clock[b]);
            }
        }
        clock[node.chosen] = static_cast<std::uint32_t>(depth) + 1;
        node.clock = std::move(clock);
    }
    static void offer(Node& node, std::uint32_t block) {
        if (node.states[block].can_run()) {
            node.to_try.insert(block);
            return;
        }
        for (std::uint32_t b = 0; b < node.states.size(); ++b) {
            if (node.states[b].can_run()) node.to_try.insert(b);
        }
    }

    const ExploreOptions& options_;
    bool linear_ = true;
    Interleaving launch_;
    Meetings meetings_;
    std::size_t met_before_ = 0;
    std::vector<Node> path_;
    std::size_t depth_ = 0;
};

/// Leaves out switches as long as the outcome still differs from the expected one.
void shrink(const MemoryChecker& memory, const InterleavedRun& run, Exploration& exploration) {
    Interleaving& failing = *exploration.failing;
    for (std::size_t i = 0; i < failing.switches.size();) {
        Interleaving less = failing;
        less.switches.erase(less.switches.begin() + static_cast<std::ptrdiff_t>(i));
        const std::string outcome = replay(memory, run, less);
        if (outcome == exploration.expected) {
            ++i;
            continue;
        }
        failing = less;
        i = 0;
    }
    exploration.found = replay(memory, run, failing);
}

}  // namespace

Exploration explore(const MemoryChecker& memory, const InterleavedRun& run,
                    const ExploreOptions& options) {
    Exploration out;
    Search search(options);
    Interleaver interleaver(memory);
    interleaver.use(search);
    out.expected = outcome_of(run, interleaver);
    search.end_linear();
    for (bool left = true; left;) {
        if (out.schedules == options.most_schedules) break;
        const std::string outcome = outcome_of(run, interleaver);
        ++out.schedules;
        if (outcome != out.expected) {
            out.failing = search.taken();
            break;
        }
        if (search.met_anew()) {
            search.restart();
            out.schedules = 0;
        } else {
            left = search.advance();
            out.complete = !left;
        }
    }
    out.words = search.words();
    if (out.failing) shrink(memory, run, out);
    return out;
}

}  // namespace scotty::emulation::simt
