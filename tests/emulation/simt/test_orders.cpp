/// Orders of blocks and threads are the requested ones, and repeat.
#include <algorithm>

#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

/// Each phase records which threads came when.
SCOTTY_KERNEL(note_order)(std::uint32_t* next, std::uint32_t* log) {
    for (int phase = 0; phase < 2; ++phase) {
        log[atomic_add(next, 1)] = block_index() * block_size() + thread_index();
        SCOTTY_SYNC();
    }
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;

constexpr std::uint32_t kBlocks = 5;
constexpr std::uint32_t kThreads = 72;  // two warps and a part of one

std::vector<std::uint32_t> order_of(Executor& executor) {
    std::uint32_t next = 0;
    std::vector<std::uint32_t> log(2 * kBlocks * kThreads, 0);
    executor.launch("note_order", kBlocks, kThreads, note_order, &next, log.data());
    REQUIRE(next == log.size());
    return log;
}
std::vector<std::uint32_t> order_of(const SimtOptions& options) {
    Executor executor(options);
    return order_of(executor);
}

TEST_CASE("orders: linear is ascending, reversed descending, phase by phase", "[simt][order]") {
    const auto linear = order_of({0, ScheduleKind::linear, 0});
    const auto reversed = order_of({0, ScheduleKind::reversed, 0});
    for (std::uint32_t i = 0; i < linear.size(); ++i) {
        const std::uint32_t block = i / (2 * kThreads);
        CHECK(linear[i] == block * kThreads + i % kThreads);
        CHECK(reversed[i] == kBlocks * kThreads - 1 - linear[i]);
    }
}

TEST_CASE("orders: adversarial starts at the last thread, another block first at each launch",
          "[simt][order]") {
    Executor executor({0, ScheduleKind::adversarial, 0});
    const auto first = order_of(executor);
    const auto second = order_of(executor);
    CHECK(first[0] == 2 * kThreads - 1);  // block 1: block 0 comes last
    CHECK(first.back() == 0);
    CHECK(second[0] == 5 * kThreads - 1);
    CHECK(second[2 * kThreads] == kThreads - 1);
}

TEST_CASE("orders: strided takes warps and lanes in strides too", "[simt][order]") {
    const auto order = order_of({0, ScheduleKind::strided, 0});
    CHECK(std::vector<std::uint32_t>(order.begin(), order.begin() + 7) ==
          std::vector<std::uint32_t>{0, 6, 12, 18, 24, 30, 1});
    CHECK(order[32] == 64);  // warps 0, 2, 1
    CHECK(order[40] == 32);
}

TEST_CASE("orders: a seed gives one order, other seeds others", "[simt][order]") {
    const auto one = order_of({0, ScheduleKind::shuffled, 1});
    CHECK(one == order_of({0, ScheduleKind::shuffled, 1}));
    CHECK(one != order_of({0, ScheduleKind::shuffled, 2}));
    CHECK(one != order_of({0, ScheduleKind::linear, 0}));
}

TEST_CASE("orders: launches and phases of one seed are shuffled differently, and replay",
          "[simt][order]") {
    Executor a({0, ScheduleKind::shuffled, 7});
    Executor b({0, ScheduleKind::shuffled, 7});
    const auto first = order_of(a);
    const auto second = order_of(a);
    CHECK(first != second);
    CHECK(first == order_of(b));
    CHECK(second == order_of(b));
    CHECK_FALSE(std::equal(first.begin(), first.begin() + kThreads, first.begin() + kThreads));
    // In every order, a block's phases do not overlap and no thread is left out.
    for (std::uint32_t phase = 0; phase < 2 * kBlocks; ++phase) {
        std::vector<std::uint32_t> part(first.begin() + phase * kThreads,
                                        first.begin() + (phase + 1) * kThreads);
        std::sort(part.begin(), part.end());
        for (std::uint32_t i = 0; i < kThreads; ++i) {
            CHECK(part[i] == part[0] / kThreads * kThreads + i);
        }
    }
}

}  // namespace
