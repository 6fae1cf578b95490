/// What is wrong with a CUDA program, as data: collected while it runs, grouped, sorted, written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "emulation/cuda/include/scotty_cuda/interface.h"

namespace scotty::emulation::cuda {

/// In the order in which reports give them: what explains others comes first.
enum class FindingKind : std::uint8_t {
    race,
    same_value_race,
    divergence,
    bounds,
    freed,
    constant_write,
    host_memory,
    device_memory,  ///< touched by the host
    misaligned,
    unwritten,
    endless,
    assertion,
    trap,
    launch,
    call,  ///< of the runtime, with arguments that it refuses
    leak,
};
/// "race", "same-value race", "bounds", ...
const char* to_string(FindingKind kind);

/// An access or a stop of one thread.
struct Actor {
    bool known = false;
    std::string does;  ///< "writes it"
    scotty_cuda::Dim block;
    scotty_cuda::Dim thread;
    std::uint32_t place = 0;  ///< offset in the program's text
    std::uint32_t stack = 0;  ///< of calls
    bool in_kernel = true;
};

struct Finding {
    FindingKind kind = FindingKind::race;
    std::string kernel;  ///< empty: the host's own
    std::string what;    ///< a sentence without its places
    Actor one;
    Actor other;                  ///< the earlier of two
    std::uint32_t allocated = 0;  ///< place of the memory's allocation
    std::uint64_t times = 1;
};

/// The calls that lead to a place, as a tree: a stack is a node.
class CallTree {
 public:
    /// A call from `place` of the function that begins at `entry`.
    std::uint32_t enter(std::uint32_t parent, std::uint32_t place, std::uint32_t entry) {
        const auto [at, is_new] =
            children_.try_emplace({parent, place}, static_cast<std::uint32_t>(nodes_.size()));
        if (is_new) nodes_.push_back({parent, place, entry});
        return at->second;
    }
    std::uint32_t parent(std::uint32_t node) const { return nodes_[node].parent; }
    /// The function of this call copies a record, as the compiler has written it.
    void mark_copy(std::uint32_t node) { copies_.insert(nodes_[node].entry); }
    /// Whether it does: the place of the call says more than one in the function.
    bool is_copy(std::uint32_t node) const {
        return !copies_.empty() && node != 0 && copies_.contains(nodes_[node].entry);
    }
    /// The places of the calls, innermost first.
    std::vector<std::uint32_t> places(std::uint32_t node) const;
    std::uint32_t place(std::uint32_t node) const { return nodes_[node].place; }

 private:
    struct Node {
        std::uint32_t parent = 0;
        std::uint32_t place = 0;
        std::uint32_t entry = 0;
    };
    std::set<std::uint32_t> copies_;  ///< entries
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> children_;
    std::vector<Node> nodes_{1};
};

class Findings {
 public:
    /// Adds it, or counts one more of a finding of the same kind, kernel and places. Returns its
    /// position.
    std::size_t add(Finding finding);
    /// The second writer of a same_value_race has written another value after all.
    void make_race(std::size_t position);
    std::size_t size() const { return findings_.size(); }
    const std::vector<Finding>& all() const { return findings_; }
    CallTree& calls() { return calls_; }

    /// Sorted, for people: each with the lines of both sides, the calls and the allocation.
    std::string to_text() const;
    std::string to_json() const;
    /// Whether the program passes: no findings but warnings.
    bool passes() const;
    /// The text of all, or of all but warnings; they are forgotten.
    std::string take(bool warnings);

 private:
    std::vector<Finding> sorted() const;
    /// What a function that copies a record does, its caller does.
    void leave_copies(Actor& actor) const;

    std::vector<Finding> findings_;
    std::map<std::tuple<FindingKind, std::string, std::uint32_t, std::uint32_t, std::string>,
             std::size_t>
        known_;
    CallTree calls_;
};

/// Whether findings of the kind are remarks only.
bool is_warning(FindingKind kind);

}  // namespace scotty::emulation::cuda
