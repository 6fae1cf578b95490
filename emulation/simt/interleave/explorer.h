/// Runs a launch in every order in which its blocks can touch memory, and compares the outcomes.
///
/// Blocks meet only in words of device memory that two of them touch and one of them changes. All
/// other steps of a block commute with those of other blocks, so the order can matter only there,
/// and only there blocks are switched. These words are found by running: each run notes what it
/// touches, and the search begins again whenever a run shows a new shared word. It tries orders
/// that differ in the order of two dependent accesses (dynamic partial-order reduction: Flanagan
/// and Godefroid 2005), so it sees every outcome of any order without running every order. Inside a
/// block the order of threads is linear here; schedules vary it, and the checker shows that it does
/// not matter.
///
/// With a bound it runs every order with at most that many preemptions instead (switches away from
/// a block that could go on; Musuvathi and Qadeer 2007).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "emulation/simt/interleave/interleaver.h"
#include "emulation/simt/interleave/interleaving.h"

namespace scotty::emulation::simt {

struct ExploreOptions {
    std::optional<std::uint32_t> preemptions;  ///< at most; none: exhaustive
    std::uint64_t most_schedules = 100'000;    ///< after these the search gives up, and says so
};

struct Exploration {
    std::uint64_t schedules = 0;  ///< runs of the last search, without those of the shrinking
    std::uint64_t words = 0;      ///< in which blocks meet
    bool complete = false;        ///< the search did not give up
    std::string expected;         ///< outcome of one block after the other
    /// The first schedule with another outcome, shrunk until none of its switches can be left out.
    std::optional<Interleaving> failing;
    std::string found;  ///< its outcome
};

/// Prepares memory, launches once through an executor with this interleaver (Executor::interleave)
/// and returns the outcome in a form that can be compared. An exception is an outcome too.
using InterleavedRun = std::function<std::string(Interleaver& interleaver)>;

/// `memory` belongs to that executor.
Exploration explore(const MemoryChecker& memory, const InterleavedRun& run,
                    const ExploreOptions& options = {});

/// The outcome under one schedule. Throws bad_input where the launch does not match the schedule.
std::string replay(const MemoryChecker& memory, const InterleavedRun& run,
                   const Interleaving& interleaving);

}  // namespace scotty::emulation::simt
