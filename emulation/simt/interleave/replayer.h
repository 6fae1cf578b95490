/// Runs a schedule from a file, or from a search, once more.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "emulation/simt/interleave/explorer.h"

namespace scotty::emulation::simt {

/// Follows the switches of one schedule.
class Replayer final : public Chooser {
 public:
    explicit Replayer(Interleaving interleaving) : interleaving_(std::move(interleaving)) {}

    void begin(const Launch& launch) override;
    bool begins_all() const override { return false; }
    bool stops(std::uint32_t block, std::uint32_t access, const Touch& touch) override;
    std::uint32_t choose(const std::vector<BlockState>& blocks, std::uint32_t current) override;

    const Interleaving& interleaving() const { return interleaving_; }

 private:
    const Switch* find(std::uint32_t block, std::uint32_t access) const;

    Interleaving interleaving_;
};

/// What the run returns, or what it throws.
std::string outcome_of(const InterleavedRun& run, Interleaver& interleaver);

}  // namespace scotty::emulation::simt
