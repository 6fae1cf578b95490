/// What a kernel waits for: barriers, warp collectives, collective functions.
#pragma once

#include <bit>
#include <coroutine>
#include <cstdint>
#include <cstring>

#include "emulation/simt/context.h"
#include "emulation/simt/task.h"

namespace scotty::emulation::simt {

/// Suspends the running thread; the executor comes back when all have stopped where it has.
/// What a thread brings is noted before it stops, so that its frame need not hold it.
struct Stop {
    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> self) const noexcept { context.stop->handle = self; }
};

struct Barrier : Stop {
    explicit Barrier(const Site& site) { context.stop->site = &site; }
    void await_resume() const noexcept {}
};

struct WarpBallot : Stop {
    explicit WarpBallot(bool predicate) {
        context.ballot_in |= static_cast<std::uint32_t>(predicate) << context.thread % kLanes;
    }
    std::uint32_t await_resume() const noexcept { return context.ballot_out; }
};

/// One ballot for each of the lowest `Count` bits.
template <int Count>
struct Ballots {
    std::uint32_t of[Count];
};
template <int Count>
struct WarpBallots : Stop {
    static_assert(0 < Count && Count <= static_cast<int>(kLanes));
    explicit WarpBallots(std::uint32_t bits) {
        const std::uint32_t lane = 1u << context.thread % kLanes;
        for (bits &= ~0u >> (kLanes - Count); bits != 0; bits &= bits - 1) {
            context.ballots_in[std::countr_zero(bits)] |= lane;
        }
    }
    Ballots<Count> await_resume() const noexcept {
        Ballots<Count> result;
        std::memcpy(result.of, context.ballots_out, sizeof result.of);
        return result;
    }
};

struct WarpShuffleUp : Stop {
    WarpShuffleUp(std::uint32_t value, std::uint32_t lanes_down) : delta(lanes_down) {
        context.values_in[context.thread % kLanes] = value;
    }
    std::uint32_t await_resume() const noexcept {
        const std::uint32_t lane = context.thread % kLanes;
        return context.values_out[lane < delta ? lane : lane - delta];
    }
    std::uint32_t delta;
};

/// What SCOTTY_AWAIT awaits: a collective, whose place is noted, or a function, which needs none.
template <class Collective>
Collective at(const Site& site, Collective collective) {
    context.stop->site = &site;
    return collective;
}
template <class T>
Task<T> at(const Site&, Task<T> task) {
    return task;
}

/// Notes the SCOTTY_RETURN that the running thread is about to execute.
inline void leave(const Site& site) { context.returns[context.thread] = &site; }

}  // namespace scotty::emulation::simt
