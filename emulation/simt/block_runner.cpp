#include "emulation/simt/block_runner.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "reference/assert.h"

namespace scotty::emulation::simt {

void BlockRunner::enter(const Launch& launch, std::uint32_t block) {
    arena_.reset();
    shared_.reset();
    std::fill_n(returns_.begin(), launch.threads, nullptr);
    context = {};
    context.block = block;
    context.block_size = launch.threads;
    context.grid_size = launch.blocks;
    context.values_in = values_[0].data();
    context.values_out = values_[1].data();
    context.handles = handles_.data();
    context.stops = stops_.data();
    context.returns = returns_.data();
    context.arena = &arena_;
    context.shared = &shared_;
    context.observer = launch.observer;
}

void BlockRunner::run(const Launch& launch, std::uint32_t block, ScheduleKind order,
                      std::uint64_t seed) {
    SCOTTY_ASSERT(launch.threads, <=, kMaxThreads);
    SCOTTY_ASSERT(launch.threads, >, 0u);
    enter(launch, block);
    order_.start_block(order, seed, (launch.threads + kLanes - 1) / kLanes);
    try {
        run_phase<true>(launch);
        while (stops_[0]->kind == SiteKind::barrier) {
            if (context.observer != nullptr) context.observer->on_barrier(block, *stops_[0]);
            run_phase<false>(launch);
        }
    } catch (const LaunchError&) {
        throw;
    } catch (...) {
        fail_thread(launch);
    }
    SCOTTY_ASSERT(context.started, ==, launch.threads);
    SCOTTY_ASSERT(context.finished, ==, launch.threads);
    threads_run_ += context.finished;
}

template <bool First>
void BlockRunner::run_phase(const Launch& launch) {
    order_.start_phase();
    const std::uint32_t warps = (launch.threads + kLanes - 1) / kLanes;
    bool meets = true;
    for (std::uint32_t i = 0; i < warps; ++i) {
        meets &= run_warp<First>(launch, order_.warp_order[i]);
    }
    // All warps have stopped: a divergence can be told with the places of all threads.
    for (std::uint32_t warp = 1; warp < warps; ++warp) meets &= stops_[warp * kLanes] == stops_[0];
    if (!meets) fail_divergent(launch);
}

template <bool First>
bool BlockRunner::run_warp(const Launch& launch, std::uint32_t warp) {
    const std::uint32_t base = warp * kLanes;
    const std::uint32_t lanes = std::min(kLanes, launch.threads - base);
    const Site* const* stops = stops_.data() + base;
    bool starts = First;
    for (;;) {
        context.ballot_in = 0;
        for (const std::uint8_t lane : order_.lane_order) {
            if (lane >= lanes) continue;
            context.thread = base + lane;
            if (starts) {
                launch.start(launch.arguments);
            } else {
                handles_[base + lane].resume();
            }
        }
        starts = false;
        bool same = true;
        for (std::uint32_t lane = 1; lane < lanes; ++lane) same &= stops[lane] == stops[0];
        if (!same) return false;
        if (stops[0]->kind != SiteKind::collective) return true;
        context.ballot_out = context.ballot_in;
        std::swap(context.values_in, context.values_out);
    }
}

void BlockRunner::fail_divergent(const Launch& launch) const {
    std::vector<ThreadGroup> groups;
    for (std::uint32_t thread = 0; thread < launch.threads; ++thread) {
        const Site* left_at = stops_[thread] == &kLeft ? returns_[thread] : nullptr;
        auto group = std::find_if(groups.begin(), groups.end(), [&](const ThreadGroup& g) {
            return g.stop == stops_[thread] && g.left_at == left_at;
        });
        if (group == groups.end()) {
            group = groups.insert(groups.end(), {stops_[thread], left_at, {}});
        }
        group->threads.push_back(thread);
    }
    std::string what = "its threads part:";
    for (const ThreadGroup& group : groups) {
        what += (&group == &groups.front() ? " " : "; ") + to_text(group);
    }
    throw LaunchError(launch.kernel, context.block, launch.threads, std::move(groups), what);
}

void BlockRunner::fail_thread(const Launch& launch) const {
    std::string what = "an exception of unknown type";
    try {
        throw;
    } catch (const std::exception& error) {
        what = error.what();
    } catch (...) {
    }
    throw LaunchError(launch.kernel, context.block, launch.threads, {},
                      "thread " + std::to_string(context.thread) + " failed: " + what);
}

}  // namespace scotty::emulation::simt
