#include "emulation/simt/block_runner.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <exception>
#include <utility>

#include "emulation/check/bad_address.h"
#include "emulation/check/memory_checker.h"
#include "reference/base/assert.h"

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
    masks_.fill(0);
    context.ballots_in = ballots_[0].data();
    context.ballots_out = ballots_[1].data();
    context.values_in = values_[0].data();
    context.values_out = values_[1].data();
    context.masks = masks_.data();
    context.returns = returns_.data();
    context.arena = &arena_;
    context.shared = &shared_;
    context.interleaver = launch.interleaver;
    context.late_stores = launch.late_stores;
    if (launch.checker == nullptr) return;
    shared_shadow_.resize(SharedMemory::kBytes / 4);
    context.checker = launch.checker;
    context.first_block = launch.first_block;
    context.shared_shadow = shared_shadow_.data();
}

void BlockRunner::run(const Launch& launch, std::uint32_t block, ScheduleKind order,
                      std::uint64_t seed) {
    SCOTTY_ASSERT(launch.threads, <=, kMaxThreads);
    SCOTTY_ASSERT(launch.threads, >, 0u);
    enter(launch, block);
    if (launch.dynamic_shared != 0) {
        shared_.object(&kDynamicShared, "dynamic shared memory", launch.dynamic_shared, 16);
    }
    order_.start_block(order, seed, (launch.threads + kLanes - 1) / kLanes);
    try {
        const std::string bad_address = bad_address_in([&] {
            run_phase<true>(launch);
            while (stops_[0].site->kind == SiteKind::barrier) {
                ++context.phase;
                run_phase<false>(launch);
            }
        });
        if (!bad_address.empty()) {
            throw LaunchError(launch.kernel, block, launch.threads, {}, bad_address);
        }
    } catch (const LaunchError&) {
        leave();
        throw;
    } catch (...) {
        leave();
        fail_thread(launch);
    }
    SCOTTY_ASSERT(context.started, ==, launch.threads);
    SCOTTY_ASSERT(context.finished, ==, launch.threads);
    threads_run_ += context.finished;
    leave();
}

void BlockRunner::leave() {
    if (context.checker != nullptr) context.checker->end_block(context);
    context.checker = nullptr;
    context.interleaver = nullptr;
    context.late_stores = nullptr;
}

template <bool First>
void BlockRunner::run_phase(const Launch& launch) {
    order_.start_phase();
    const std::uint32_t warps = (launch.threads + kLanes - 1) / kLanes;
    bool meets = true;
    for (std::uint32_t i = 0; i < warps; ++i) {
        meets &= run_warp<First>(launch, order_.warp_order[i]);
    }
    // All warps have stopped, so a divergence can be reported with the places of all threads.
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
    context.lanes = lanes;
    // Clears what lanes that did not meet have left; the other warps run all the same.
    context.ballot_in = 0;
    if (context.masked) {
        masks_.fill(0);
        context.masked = false;
    }
    const auto take_turns = [&](const auto& turn) {
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
        if (context.masked) [[unlikely]] {
            context.masked = false;
            if (run_masked(launch, base, lanes)) continue;
        }
        const Site* const site = stops[0].site;
        std::uintptr_t other = 0;
        for (std::uint32_t lane = 1; lane < lanes; ++lane) {
            other |= reinterpret_cast<std::uintptr_t>(stops[lane].site) ^
                     reinterpret_cast<std::uintptr_t>(site);
        }
        if (other != 0) return false;
        if (site->kind != SiteKind::collective) return true;
        if (masks_[0] != 0) return false;  // at a mask that also names other lanes
        context.ballot_out = std::exchange(context.ballot_in, 0);
        std::swap(context.values_in, context.values_out);
        std::swap(context.ballots_in, context.ballots_out);
        std::memset(context.ballots_in, 0, sizeof ballots_[0]);
        take_turns([](const ThreadStop& stop) { stop.handle.resume(); });
    }
}

bool BlockRunner::run_masked(const Launch& launch, std::uint32_t base, std::uint32_t lanes) {
    ThreadStop* const stops = stops_.data() + base;
    const std::uint32_t there = lanes < kLanes ? (1u << lanes) - 1u : ~0u;
    bool went_on = false;
    for (std::uint32_t first = 0; first < lanes; ++first) {
        const std::uint32_t mask = masks_[first];
        if (mask == 0) continue;
        if ((mask >> first & 1u) == 0) fail_mask(launch, base + first, mask);
        bool ready = true;
        for (std::uint32_t lane = 0; lane < lanes; ++lane) {
            if ((mask >> lane & 1u) == 0) continue;
            ready &= stops[lane].site == stops[first].site && masks_[lane] == mask;
        }
        if (!ready) continue;
        went_on = true;
        for (std::uint32_t bits = mask & there; bits != 0; bits &= bits - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
            context.values_out[lane] = context.values_in[lane];
            masks_[lane] = 0;
        }
        for (const std::uint8_t lane : order_.lane_order) {
            if (lane >= lanes || (mask >> lane & 1u) == 0) continue;
            context.thread = base + lane;
            context.stop = stops + lane;
            stops[lane].handle.resume();
        }
    }
    context.masked = std::any_of(masks_.begin(), masks_.begin() + lanes,
                                 [](std::uint32_t mask) { return mask != 0; });
    return went_on;
}

void BlockRunner::fail_mask(const Launch& launch, std::uint32_t thread, std::uint32_t mask) const {
    char bits[16];
    std::snprintf(bits, sizeof bits, "0x%08x", mask);
    throw LaunchError(launch.kernel, context.block, launch.threads, {},
                      to_text(ThreadGroup{stops_[thread].site, nullptr, {thread}}) +
                          " with a mask that it is not in: " + bits);
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
