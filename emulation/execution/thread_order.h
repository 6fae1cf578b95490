/// The order in which the warps of a block, and the lanes of a warp, take turns.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <random>

#include "emulation/execution/context.h"
#include "emulation/execution/schedule.h"

namespace scotty::emulation::simt {

/// Mixes the numbers that name a block of a launch into the seed of its orders.
constexpr std::uint64_t mixed(std::uint64_t seed, std::uint64_t launch, std::uint64_t block) {
    std::uint64_t x = seed + 0x9e3779b97f4a7c15ull * (launch + 1) + 0xbf58476d1ce4e5b9ull * block;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// Fisher and Yates' shuffle. std::shuffle's order is the library's choice, and a seed must replay
/// everywhere.
template <class Iterator, class Generator>
void shuffle(Iterator begin, Iterator end, Generator& generator) {
    for (auto left = static_cast<std::uint64_t>(end - begin); left > 1; --left) {
        std::swap(begin[static_cast<std::ptrdiff_t>(left - 1)],
                  begin[static_cast<std::ptrdiff_t>(generator() % left)]);
    }
}

class ThreadOrder {
 public:
    void start_block(ScheduleKind kind, std::uint64_t seed, std::uint32_t warps) {
        shuffles_ = kind == ScheduleKind::shuffled;
        warps_ = warps;
        std::iota(warp_order.begin(), warp_order.begin() + warps, std::uint8_t{0});
        std::iota(lane_order.begin(), lane_order.end(), std::uint8_t{0});
        if (kind == ScheduleKind::reversed || kind == ScheduleKind::adversarial) {
            std::reverse(warp_order.begin(), warp_order.begin() + warps);
            std::reverse(lane_order.begin(), lane_order.end());
        }
        if (kind == ScheduleKind::strided) {
            take_strided(warp_order.begin(), warps);
            take_strided(lane_order.begin(), kLanes);
        }
        if (shuffles_) generator_.seed(seed);
    }
    /// Called before each phase of the block; a shuffled order changes.
    void start_phase() {
        if (!shuffles_) return;
        shuffle(warp_order.begin(), warp_order.begin() + warps_, generator_);
        shuffle(lane_order.begin(), lane_order.end(), generator_);
    }

    std::array<std::uint8_t, kMaxThreads / kLanes> warp_order{};
    std::array<std::uint8_t, kLanes> lane_order{};

 private:
    /// The same order as for blocks: block_order().
    template <class Iterator>
    static void take_strided(Iterator out, std::uint32_t count) {
        for (const std::uint32_t i : block_order({ScheduleKind::strided, 0}, 1, count)) {
            *out++ = static_cast<std::uint8_t>(i);
        }
    }

    bool shuffles_ = false;
    std::uint32_t warps_ = 0;
    std::mt19937_64 generator_;
};

}  // namespace scotty::emulation::simt
