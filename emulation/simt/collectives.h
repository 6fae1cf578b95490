/// Everything that a kernel waits for: barriers, warp collectives, collective functions.
#pragma once

#include <bit>
#include <coroutine>
#include <cstdint>
#include <cstring>

#include "emulation/execution/context.h"
#include "emulation/simt/task.h"

namespace scotty::emulation::simt {

/// Suspends the running thread; the executor comes back when all have stopped at the same place. A
/// thread's contribution is noted before it stops, so that its frame need not hold it.
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

/// Takes one ballot for each of the lowest `Count` bits.
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

/// A collective of the lanes that a mask names, and of no others: lanes of one warp may wait at
/// several. Each lane's contribution is visible to all of them.
struct MaskedStop : Stop {
    MaskedStop(std::uint32_t value, std::uint32_t lanes) : mask(lanes) {
        context.values_in[context.thread % kLanes] = value;
        context.masks[context.thread % kLanes] = lanes;
        context.masked = true;
    }
    std::uint32_t mask;

 protected:
    /// Bit i: lane i takes part and has brought `value`.
    std::uint32_t lanes_with(std::uint32_t value) const noexcept {
        std::uint32_t lanes = 0;
        const std::uint32_t there = context.lanes < kLanes ? (1u << context.lanes) - 1u : ~0u;
        for (std::uint32_t bits = mask & there; bits != 0; bits &= bits - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
            lanes |= static_cast<std::uint32_t>(context.values_out[lane] == value) << lane;
        }
        return lanes;
    }
    /// The value of a lane that takes part; for any other lane, the thread's own.
    std::uint32_t value_of(std::uint32_t lane) const noexcept {
        const bool takes_part = lane < context.lanes && (mask >> lane & 1u) != 0;
        return context.values_out[takes_part ? lane : context.thread % kLanes];
    }
};

struct MaskedBallot : MaskedStop {
    MaskedBallot(bool predicate, std::uint32_t lanes) : MaskedStop(predicate ? 1 : 0, lanes) {}
    std::uint32_t await_resume() const noexcept { return lanes_with(1); }
};
struct WarpAny : MaskedStop {
    WarpAny(bool predicate, std::uint32_t lanes) : MaskedStop(predicate ? 1 : 0, lanes) {}
    bool await_resume() const noexcept { return lanes_with(1) != 0; }
};
struct WarpAll : MaskedStop {
    WarpAll(bool predicate, std::uint32_t lanes) : MaskedStop(predicate ? 1 : 0, lanes) {}
    bool await_resume() const noexcept { return lanes_with(0) == 0; }
};
struct WarpMatch : MaskedStop {
    using MaskedStop::MaskedStop;
    std::uint32_t await_resume() const noexcept { return lanes_with(value_of(kLanes)); }
};
struct WarpShuffle : MaskedStop {
    WarpShuffle(std::uint32_t value, std::uint32_t lane, std::uint32_t lanes)
        : MaskedStop(value, lanes), from(lane) {}
    std::uint32_t await_resume() const noexcept { return value_of(from % kLanes); }
    std::uint32_t from;
};

/// What SCOTTY_AWAIT awaits: a collective, which notes its place, or a function, which needs none.
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
