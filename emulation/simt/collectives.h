/// What a kernel waits for: barriers, warp collectives, collective functions.
#pragma once

#include <coroutine>
#include <cstdint>

#include "emulation/simt/context.h"
#include "emulation/simt/task.h"

namespace scotty::emulation::simt {

/// The executor goes on with the next thread and comes back when all of the block are here.
struct Barrier {
    const Site* site;
    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> self) const noexcept { stop_at(*site, self); }
    void await_resume() const noexcept {}
};

struct WarpBallot {
    bool predicate;
    const Site* site = nullptr;
    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> self) const noexcept {
        context.ballot_in |= static_cast<std::uint32_t>(predicate) << context.thread % kLanes;
        stop_at(*site, self);
    }
    std::uint32_t await_resume() const noexcept { return context.ballot_out; }
};

struct WarpShuffleUp {
    std::uint32_t value;
    std::uint32_t delta;
    const Site* site = nullptr;
    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> self) const noexcept {
        context.values_in[context.thread % kLanes] = value;
        stop_at(*site, self);
    }
    std::uint32_t await_resume() const noexcept {
        const std::uint32_t lane = context.thread % kLanes;
        return lane < delta ? value : context.values_out[lane - delta];
    }
};

/// What SCOTTY_AWAIT awaits: a collective that knows its place, or a function, which needs none.
template <class Collective>
Collective at(const Site& site, Collective collective) {
    collective.site = &site;
    return collective;
}
template <class T>
Task<T> at(const Site&, Task<T> task) {
    return task;
}

/// Notes the SCOTTY_RETURN that the running thread is about to execute.
inline void leave(const Site& site) { context.returns[context.thread] = &site; }

}  // namespace scotty::emulation::simt
