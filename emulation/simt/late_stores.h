/// Stores that other blocks see late, as a device's memory allows.
///
/// Where blocks run one after the other, each finds what all blocks before it have published, so
/// code that waits for a neighbour, or goes on without it, would never run. Under an adversarial or
/// shuffled schedule a relaxed load therefore finds the word as it was before its last store, until
/// some number of blocks have started since. A thread that has seen a store never sees the word
/// before it again, and whoever waits sees it soon.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "emulation/execution/thread_order.h"

namespace scotty::emulation::simt {

class LateStores {
 public:
    explicit LateStores(std::uint64_t seed) : seed_(seed) {}

    void block_starts() { ++blocks_; }
    void stored(const std::uint64_t* word, std::uint64_t before) {
        stores_[word] = {before, blocks_, 0, 0};
    }
    /// What a load of the word finds; `now` is what it holds.
    std::uint64_t loaded(const std::uint64_t* word, std::uint64_t now) {
        const auto found = stores_.find(word);
        if (found == stores_.end()) return now;
        Store& store = found->second;
        if (store.reader != blocks_) store.reads = 0;
        store.reader = blocks_;
        // The stores of neighbours are equally late, by up to 127 blocks: longer than three warps
        // look back, so that a whole window of theirs is out of date.
        const std::uint64_t late = mixed(seed_, 0, store.writer / 64) % 128;
        if (store.writer == blocks_ || blocks_ - store.writer > late || store.reads == kReads) {
            return now;
        }
        ++store.reads;
        ++late_loads_;
        return store.before;
    }
    std::uint64_t late_loads() const { return late_loads_; }

 private:
    static constexpr std::uint32_t kReads = 2;  ///< of one block, until it sees the store

    struct Store {
        std::uint64_t before = 0;
        std::uint64_t writer = 0;  ///< blocks are numbered as they start, from 1
        std::uint64_t reader = 0;
        std::uint32_t reads = 0;  ///< of that reader, which did not see the store
    };
    std::uint64_t seed_;
    std::uint64_t blocks_ = 0;
    std::uint64_t late_loads_ = 0;
    std::unordered_map<const std::uint64_t*, Store> stores_;
};

}  // namespace scotty::emulation::simt
