#include "emulation/simt/block_runner.h"

#include <algorithm>
#include <cstring>
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
    ballots_[0].fill(0);
    context.ballots_in = ballots_[0].data();
    context.ballots_out = ballots_[1].data();
    context.values_in = values_[0].data();
    context.values_out = values_[1].data();
    context.returns = returns_.data();
    context.arena = &arena_;
    context.shared = &shared_;
    context.kernel = launch.kernel;
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
        while (stops_[0].site->kind == SiteKind::barrier) {
            if (context.observer != nullptr) context.observer->on_barrier(block, *stops_[0].site);
            run_phase<false>(launch);
        }
    } catch (const LaunchError&) {
        context.kernel = nullptr;
        throw;
    } catch (...) {
        context.kernel = nullptr;
        fail_thread(launch);
    }
    SCOTTY_ASSERT(context.started, ==, launch.threads);
    SCOTTY_ASSERT(context.finished, ==, launch.threads);
    threads_run_ += context.finished;
    context.kernel = nullptr;
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
    for (std::uint32_t warp = 1; warp < warps; ++warp) {
        meets &= stops_[warp * kLanes].site == stops_[0].site;
    }
    if (!meets) fail_divergent(launch);
}

template <bool First>
bool BlockRunner::run_warp(const Launch& launch, std::uint32_t warp) {
    const std::uint32_t base = warp * kLanes;
    const std::uint32_t lanes = std::min(kLanes, launch.threads - base);
    ThreadStop* const stops = stops_.data() + base;
    const auto take_turns = [&](const auto& turn) {
        context.ballot_in = 0;
        for (const std::uint8_t lane : order_.lane_order) {
            if (lane >= lanes) continue;
            context.thread = base + lane;
            context.stop = stops + lane;
            turn(stops[lane]);
        }
    };
    if (First) {
        take_turns([&](const ThreadStop&) { launch.start(launch.arguments); });
    } else {
        take_turns([](const ThreadStop& stop) { stop.handle.resume(); });
    }
    for (;;) {
        const Site* const site = stops[0].site;
        std::uintptr_t other = 0;
        for (std::uint32_t lane = 1; lane < lanes; ++lane) {
            other |= reinterpret_cast<std::uintptr_t>(stops[lane].site) ^
                     reinterpret_cast<std::uintptr_t>(site);
        }
        if (other != 0) return false;
        if (site->kind != SiteKind::collective) return true;
        context.ballot_out = context.ballot_in;
        std::swap(context.values_in, context.values_out);
        std::swap(context.ballots_in, context.ballots_out);
        std::memset(context.ballots_in, 0, sizeof ballots_[0]);
        take_turns([](const ThreadStop& stop) { stop.handle.resume(); });
    }
}

void BlockRunner::fail_divergent(const Launch& launch) const {
    std::vector<ThreadGroup> groups;
    for (std::uint32_t thread = 0; thread < launch.threads; ++thread) {
        const Site* left_at = stops_[thread].site == &kLeft ? returns_[thread] : nullptr;
        auto group = std::find_if(groups.begin(), groups.end(), [&](const ThreadGroup& g) {
            return g.stop == stops_[thread].site && g.left_at == left_at;
        });
        if (group == groups.end()) {
            group = groups.insert(groups.end(), {stops_[thread].site, left_at, {}});
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
