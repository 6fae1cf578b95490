/// Warp collectives of some lanes only, and shared memory whose size the launch gives.
#include <algorithm>

#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

/// Even and odd lanes go different ways; each side has collectives of its own.
SCOTTY_KERNEL(two_sides)(std::uint32_t* out) {
    const bool odd = lane_index() % 2 != 0;
    std::uint32_t result = 0;
    if (odd) {
        result = SCOTTY_AWAIT(warp_ballot(lane_index() < 16, 0xaaaaaaaau));
        result += SCOTTY_AWAIT(warp_shuffle(100 + lane_index(), 31, 0xaaaaaaaau));
    } else if (SCOTTY_AWAIT(warp_any(lane_index() == 30, 0x55555555u))) {
        result = SCOTTY_AWAIT(warp_all(lane_index() == 30, 0x55555555u)) ? 1 : 2;
    }
    const std::uint32_t together = SCOTTY_AWAIT(warp_ballot(odd));
    out[thread_index()] = together == 0xaaaaaaaau ? result : 0xffffffffu;
}

SCOTTY_KERNEL(groups)(std::uint32_t* out) {
    out[thread_index()] = SCOTTY_AWAIT(warp_match(lane_index() % 3));
    SCOTTY_RETURN;
}

/// The mask of the lanes that have work left, as a loop with an early exit computes it.
SCOTTY_KERNEL(fewer_and_fewer)(std::uint32_t* out) {
    std::uint32_t rounds = 0;
    for (std::uint32_t mask = SCOTTY_AWAIT(warp_ballot(lane_index() != 0));
         rounds < lane_index();) {
        ++rounds;
        mask = SCOTTY_AWAIT(warp_ballot(rounds < lane_index(), mask));
    }
    SCOTTY_SYNC();
    out[thread_index()] = rounds;
}

SCOTTY_KERNEL(not_in_its_mask)(std::uint32_t* out) {
    out[thread_index()] = SCOTTY_AWAIT(warp_ballot(true, 0x0000ffffu));
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(mask_of_who_has_left)(std::uint32_t* out) {
    if (lane_index() == 9) SCOTTY_RETURN;
    out[thread_index()] = SCOTTY_AWAIT(warp_ballot(true, kWholeWarp));
}

/// The first warp waits for a lane that has left; the other warps do not depend on it.
SCOTTY_KERNEL(one_warp_waits)(std::uint32_t* out) {
    if (warp_index() == 0) {
        if (lane_index() == 9) SCOTTY_RETURN;
        out[thread_index()] = SCOTTY_AWAIT(warp_ballot(true, kWholeWarp));
    }
    SCOTTY_SYNC();
    out[thread_index()] = SCOTTY_AWAIT(warp_ballot(lane_index() == 3));
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(reverse_dynamic)(std::uint32_t* out) {
    SCOTTY_SHARED(std::uint32_t, first);
    SCOTTY_SHARED_DYNAMIC(std::uint32_t, values);
    if (thread_index() == 0) first = 1000;
    values[thread_index()] = thread_index();
    SCOTTY_SYNC();
    out[thread_index()] = first + values[block_size() - 1 - thread_index()];
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;
using scotty::emulation::simt::Grid;

TEST_CASE("executor: lanes of one warp meet at different collectives, by their masks",
          "[simt][collectives]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> out(64, 0);
        Executor(options).launch("two_sides", 1, 64, two_sides, out.data());
        for (std::uint32_t thread = 0; thread < 64; ++thread) {
            CHECK(out[thread] == (thread % 2 != 0 ? 0x0000aaaau + 131u : 2u));
        }
    }
}

TEST_CASE("executor: lanes are grouped by value, and a short warp has no more than it has",
          "[simt][collectives]") {
    for (const std::uint32_t threads : {32u, 20u, 40u}) {
        std::vector<std::uint32_t> out(threads, 0);
        Executor().launch("groups", 1, threads, groups, out.data());
        for (std::uint32_t thread = 0; thread < threads; ++thread) {
            std::uint32_t same = 0;
            const std::uint32_t begin = thread / 32 * 32;
            for (std::uint32_t other = begin; other < std::min(begin + 32, threads); ++other) {
                same |= static_cast<std::uint32_t>(other % 32 % 3 == thread % 32 % 3) << other % 32;
            }
            CHECK(out[thread] == same);
        }
    }
}

TEST_CASE("executor: a loop that fewer and fewer lanes run", "[simt][collectives]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> out(64, 99);
        Executor(options).launch("fewer_and_fewer", 1, 64, fewer_and_fewer, out.data());
        for (std::uint32_t thread = 0; thread < 64; ++thread) CHECK(out[thread] == thread % 32);
    }
}

TEST_CASE("executor: a mask without the lane itself, or with one that has left, is an error",
          "[simt][collectives]") {
    using Catch::Matchers::ContainsSubstring;
    std::vector<std::uint32_t> out(32, 0);
    const auto outside =
        error_of([&] { Executor().launch("not_in_its_mask", 1, 32, not_in_its_mask, out.data()); });
    CHECK_THAT(outside.what(), ContainsSubstring("kernel not_in_its_mask, block 0") &&
                                   ContainsSubstring("waits at the warp collective") &&
                                   ContainsSubstring("with a mask that it is not in: 0x0000ffff"));
    const auto left = error_of([&] {
        Executor().launch("mask_of_who_has_left", 1, 32, mask_of_who_has_left, out.data());
    });
    CHECK_THAT(left.what(),
               ContainsSubstring("thread 9 has left the kernel") &&
                   ContainsSubstring("threads 0-8, 10-31 wait at the warp collective"));
    std::vector<std::uint32_t> more(96, 0);
    const auto one =
        error_of([&] { Executor().launch("one_warp_waits", 1, 96, one_warp_waits, more.data()); });
    CHECK_THAT(one.what(),
               ContainsSubstring("thread 9 has left the kernel") &&
                   ContainsSubstring("threads 0-8, 10-31 wait at the warp collective") &&
                   ContainsSubstring("threads 32-95 wait at the barrier"));
}

TEST_CASE("executor: a launch gives a block shared memory beside what the kernel declares",
          "[simt][shared]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> out(96, 0);
        Executor executor(options);
        executor.launch("reverse_dynamic", Grid{1, 96, 96 * 4}, reverse_dynamic, out.data());
        for (std::uint32_t thread = 0; thread < 96; ++thread) {
            CHECK(out[thread] == 1000 + 95 - thread);
        }
    }
    std::vector<std::uint32_t> out(32, 0);
    CHECK_THAT(
        error_of([&] {
            Executor().launch("reverse_dynamic", Grid{1, 32, 49152}, reverse_dynamic, out.data());
        }).what(),
        Catch::Matchers::ContainsSubstring("a block has 48 KiB"));
}

}  // namespace
