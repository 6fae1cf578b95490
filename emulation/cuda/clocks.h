/// What a CUDA thread knows of the others: vector clocks, kept sparse.
///
/// Every thread counts the times at which it synchronises. An access at count c of a thread happens
/// before everything that knows more than c of that thread (Lamport 1978; FastTrack, Flanagan and
/// Freund 2009). Most knowledge is by block (a barrier) or by warp, and needs no map; Clocks holds
/// what came through atomics and fences.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>

namespace scotty::emulation::cuda {

/// Knowledge of single threads and of whole blocks, by numbers within a launch.
class Clocks {
 public:
    /// All accesses of the block's threads at counts below the result are known; 0: none.
    std::uint32_t of_block(std::uint32_t block) const { return get(key(block, kWhole)); }
    std::uint32_t of_thread(std::uint32_t block, std::uint32_t thread) const {
        return std::max(of_block(block), get(key(block, thread)));
    }
    void know_block(std::uint32_t block, std::uint32_t below) { raise(key(block, kWhole), below); }
    void know_thread(std::uint32_t block, std::uint32_t thread, std::uint32_t below) {
        raise(key(block, thread), below);
    }
    void join(const Clocks& other) {
        for (const auto& [who, below] : other.known_) raise(who, below);
    }

 private:
    static constexpr std::uint32_t kWhole = 0xfff;
    static std::uint64_t key(std::uint32_t block, std::uint32_t thread) {
        return std::uint64_t{block} << 12 | thread;
    }
    std::uint32_t get(std::uint64_t who) const {
        const auto found = known_.find(who);
        return found == known_.end() ? 0 : found->second;
    }
    void raise(std::uint64_t who, std::uint32_t below) {
        std::uint32_t& known = known_[who];
        known = std::max(known, below);
    }

    std::map<std::uint64_t, std::uint32_t> known_;
};

/// Null: nothing is known. Never changed after it was made, so that many threads share one.
using SharedClocks = std::shared_ptr<const Clocks>;

inline SharedClocks join(const SharedClocks& one, const SharedClocks& other) {
    if (one == nullptr || one == other) return other;
    if (other == nullptr) return one;
    auto both = std::make_shared<Clocks>(*one);
    both->join(*other);
    return both;
}

}  // namespace scotty::emulation::cuda
