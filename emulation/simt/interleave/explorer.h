/// Runs a launch in every order in which its blocks can touch memory, and compares what comes out.
///
/// Blocks meet only in words of device memory that two of them touch and one of them changes. All
/// else that a block does commutes with what others do, so only there the order can matter, and
/// only there blocks are switched. Which words these are is found by running: what each run touches
/// is noted, and where it shows a new shared word the search begins again with it, until none is
/// new. Of orders of such accesses those are tried that differ in the order of two dependent ones
/// (dynamic partial-order reduction: Flanagan and Godefroid 2005): every outcome that any order has
/// is seen, though not every order. Inside a block the order of threads is linear here; other
/// orders are the schedules' affair, and that none matters is the checker's.
///
/// With a bound, instead: every order with at most so many preemptions (switches away from a block
/// that could go on; Musuvathi and Qadeer 2007).
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
    std::uint64_t most_schedules = 100'000;    ///< then it is given up, and says so
};

struct Exploration {
    std::uint64_t schedules = 0;  ///< run, of the last search; not those of the shrinking
    std::uint64_t words = 0;      ///< in which blocks meet
    bool complete = false;        ///< nothing was given up
    std::string expected;         ///< outcome of one block after the other
    /// The first schedule with another outcome, shrunk: none of its switches can be left out.
    std::optional<Interleaving> failing;
    std::string found;  ///< its outcome
};

/// Prepares memory, launches once through an executor with this interleaver (Executor::interleave)
/// and returns the outcome in a form in which equal is equal. An exception is an outcome, too.
using InterleavedRun = std::function<std::string(Interleaver& interleaver)>;

/// `memory`: of that executor.
Exploration explore(const MemoryChecker& memory, const InterleavedRun& run,
                    const ExploreOptions& options = {});

/// The outcome under one schedule. Throws bad_input where the launch is not the schedule's.
std::string replay(const MemoryChecker& memory, const InterleavedRun& run,
                   const Interleaving& interleaving);

}  // namespace scotty::emulation::simt
