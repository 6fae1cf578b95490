#include "emulation/simt/interleave/interleaver.h"

#include <algorithm>
#include <exception>
#include <string>

namespace scotty::emulation::simt {

namespace {

/// After so many releases in a row, with no write between, the blocks would wait for ever.
constexpr std::uint32_t kMostReleases = 1000;

}  // namespace

std::uint32_t next_by_default(const std::vector<BlockState>& blocks, std::uint32_t current) {
    if (blocks[current].can_run()) return current;
    const auto lowest = std::find_if(blocks.begin(), blocks.end(),
                                     [](const BlockState& block) { return block.can_run(); });
    return static_cast<std::uint32_t>(lowest - blocks.begin());
}

void Interleaver::run(const Launch& launch) {
    while (fibers_.size() < launch.blocks) {
        runners_.push_back(std::make_unique<BlockRunner>());
        fibers_.push_back(std::make_unique<Fiber>());
    }
    states_.assign(launch.blocks, {});
    waited_word_.assign(launch.blocks, 0);
    versions_.clear();
    seen_.clear();
    releases_ = 0;
    for (std::uint32_t block = 0; block < launch.blocks; ++block) {
        fibers_[block]->start([this, &launch, block] {
            runners_[block]->run(launch, block, ScheduleKind::linear, 0);
        });
    }
    chooser_->begin(launch);
    if (chooser_->begins_all()) {
        for (std::uint32_t block = 0; block < launch.blocks; ++block) resume(block);
    } else {
        resume(0);
    }
    current_ = 0;
    while (!std::all_of(states_.begin(), states_.end(), [](const auto& s) { return s.over; })) {
        if (std::none_of(states_.begin(), states_.end(),
                         [](const auto& s) { return s.can_run(); })) {
            if (++releases_ > kMostReleases) {
                throw LaunchError(launch.kernel, current_, launch.threads, {},
                                  "all blocks that are not over wait for each other");
            }
            release_one();
        }
        resume(chooser_->choose(states_, current_));
    }
}

void Interleaver::release_one() {
    for (BlockState& state : states_) {
        if (state.over) continue;
        state.waits = false;
        return;
    }
}

void Interleaver::resume(std::uint32_t block) {
    current_ = block;
    states_[block].begun = true;
    fibers_[block]->resume();
    if (!fibers_[block]->over()) return;
    states_[block].over = true;
    if (fibers_[block]->error() != nullptr) std::rethrow_exception(fibers_[block]->error());
}

bool Interleaver::reads_again(std::uint32_t word) {
    Seen& seen = seen_[std::uint64_t{context.block} << 32 | context.thread];
    const std::uint32_t version = versions_[word];
    const bool again = seen.word == word && seen.version == version;
    seen = {word, version};
    return again;
}

void Interleaver::on_access(Access access, const void* address, std::size_t bytes) {
    const std::uintptr_t offset = memory_.offset_of(address);
    if (offset >= MemoryChecker::kDeviceBytes) return;
    const Touch touch{static_cast<std::uint32_t>(offset / 4),
                      static_cast<std::uint32_t>((offset + bytes - 1) / 4),
                      access == Access::write || access == Access::atomic};
    BlockState& state = states_[context.block];
    ++state.accesses;
    state.next = touch;
    const bool stops = chooser_->stops(context.block, state.accesses, touch);
    if (access == Access::relaxed_read && reads_again(touch.first)) {
        state.waits = true;
        waited_word_[context.block] = touch.first;
    }
    if (stops || state.waits) fibers_[context.block]->stand();
    if (!touch.writes) return;
    releases_ = 0;
    for (std::uint32_t word = touch.first; word <= touch.last; ++word) {
        ++versions_[word];
        for (std::uint32_t block = 0; block < states_.size(); ++block) {
            if (waited_word_[block] == word) states_[block].waits = false;
        }
    }
}

}  // namespace scotty::emulation::simt
