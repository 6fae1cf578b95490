/// Threads that do not meet, and threads that fail: each case is an error that names them.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

#include "emulation/simt/cuda/cuda_runtime.h"
#include "emulation/simt/current_device.h"
#include "reference/base/assert.h"
#include "tests/emulation/simt/bad_addresses.h"
#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

struct Lines {
    static constexpr std::uint32_t kBranch = __LINE__ + 5;
};
SCOTTY_KERNEL(barrier_in_branch)(std::uint32_t split) {
    if (block_index() == 1) {
        if (thread_index() < split) {
            SCOTTY_SYNC();
        } else {
            SCOTTY_SYNC();
        }
    }
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(one_skips)(std::uint32_t skips) {
    if (thread_index() != skips) SCOTTY_SYNC();
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(leaves_before_barrier)(std::uint32_t count) {
    if (thread_index() >= count) SCOTTY_RETURN;
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(ends_before_barrier)() {
    if (thread_index() % 2 == 0) {
        SCOTTY_SYNC();
    }
}

SCOTTY_KERNEL(leaves_before_ballot)(std::uint32_t* out) {
    if (lane_index() == 3) SCOTTY_RETURN;
    *out = SCOTTY_AWAIT(warp_ballot(true));
}

SCOTTY_KERNEL(half_a_warp_ballots)(std::uint32_t* out) {
    if (lane_index() < 16) *out = SCOTTY_AWAIT(warp_ballot(true));
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(two_ballots)(std::uint32_t* out) {
    if (lane_index() < 16) {
        *out = SCOTTY_AWAIT(warp_ballot(true));
    } else {
        *out = SCOTTY_AWAIT(warp_ballot(false));
    }
}

/// A barrier in a loop that threads leave in different rounds.
SCOTTY_KERNEL(uneven_loop)() {
    for (std::uint32_t turn = 0; turn <= thread_index() / 32; ++turn) SCOTTY_SYNC();
    SCOTTY_SYNC();
}

SCOTTY_COLLECTIVE(void) wait() {
    SCOTTY_SYNC();
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(two_calls)() {
    // The same barrier is reached in two ways: to the device, and here, it is one place.
    if (thread_index() < 32) {
        SCOTTY_AWAIT(wait());
    } else {
        SCOTTY_AWAIT(wait());
    }
}

/// A collective function returns before the kernel ends: the error names the kernel's end.
SCOTTY_KERNEL(ends_after_call)() {
    SCOTTY_AWAIT(wait());
    if (thread_index() != 7) SCOTTY_SYNC();
}

SCOTTY_KERNEL(throws)(std::uint32_t block, std::uint32_t thread, std::uint32_t* after) {
    SCOTTY_SYNC();
    if (block_index() == block && thread_index() == thread)
        throw std::runtime_error("no such luck");
    SCOTTY_SYNC();
    atomic_add(after, block_index() == block ? 1 : 0);
}
SCOTTY_COLLECTIVE(void) assert_small(std::uint32_t value) {
    SCOTTY_SYNC();
    SCOTTY_ASSERT(value, <, 40u);
    SCOTTY_SYNC();
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(asserts)() { SCOTTY_AWAIT(assert_small(thread_index())); }
SCOTTY_KERNEL(writes_nowhere)(volatile std::uint32_t* nowhere) {
    SCOTTY_SYNC();
    if (block_index() == 2 && thread_index() == 33) *nowhere = 1;
}
SCOTTY_KERNEL(throws_at_once)() {
    if (thread_index() == 5) throw 5;
    SCOTTY_RETURN;
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using scotty::emulation::simt::SiteKind;
using scotty::emulation::simt::thread_list;

TEST_CASE("executor: threads at two barriers are named with both lines", "[simt][divergence]") {
    for (const SimtOptions& options : every_order()) {
        for (const std::uint32_t split : {1u, 32u, 40u}) {
            const LaunchError error = error_of([&] {
                Executor(options).launch("barrier_in_branch", 3, 64, barrier_in_branch, split);
            });
            INFO(error.what());
            CHECK(error.kernel == "barrier_in_branch");
            CHECK(error.block == 1);
            REQUIRE(error.groups.size() == 2);
            CHECK(error.groups[0].threads.size() == split);
            CHECK(error.groups[1].threads.size() == 64 - split);
            CHECK(error.groups[0].stop->line == Lines::kBranch);
            CHECK(error.groups[1].stop->line == Lines::kBranch + 2);
            const std::string line = std::to_string(Lines::kBranch);
            CHECK_THAT(error.what(),
                       ContainsSubstring("kernel barrier_in_branch, block 1 (64 threads)"));
            CHECK_THAT(error.what(), ContainsSubstring("wait"));
            CHECK_THAT(error.what(),
                       ContainsSubstring(
                           "at the barrier tests/emulation/simt/test_divergence.cpp:" + line));
        }
    }
}

TEST_CASE("executor: a thread that skips a barrier waits at the next alone", "[simt][divergence]") {
    const LaunchError error =
        error_of([] { Executor().launch("one_skips", 1, 128, one_skips, 77u); });
    INFO(error.what());
    REQUIRE(error.groups.size() == 2);
    CHECK(error.groups[1].threads == std::vector<std::uint32_t>{77});
    CHECK(error.groups[1].stop->line == error.groups[0].stop->line + 1);
    CHECK_THAT(error.what(), ContainsSubstring("threads 0-76, 78-127 wait at the barrier") &&
                                 ContainsSubstring("thread 77 waits at the barrier"));
}

TEST_CASE("executor: leaving before a barrier that others wait at is an error",
          "[simt][divergence]") {
    for (const SimtOptions& options : every_order()) {
        const LaunchError error = error_of([&] {
            Executor(options).launch("leaves_before_barrier", 1, 64, leaves_before_barrier, 50u);
        });
        INFO(error.what());
        REQUIRE(error.groups.size() == 2);
        CHECK(error.groups[0].stop->kind == SiteKind::barrier);
        CHECK(error.groups[1].stop->kind == SiteKind::exit);
        REQUIRE(error.groups[1].left_at != nullptr);
        CHECK(error.groups[1].left_at->line + 1 == error.groups[0].stop->line);
        CHECK_THAT(
            error.what(),
            ContainsSubstring("threads 50-63 have left the kernel at tests/emulation/simt/"));
    }
    // A whole warp that leaves counts as much as one lane.
    CHECK_THROWS_AS(Executor().launch("leaves_before_barrier", 1, 64, leaves_before_barrier, 32u),
                    LaunchError);
    CHECK_NOTHROW(Executor().launch("leaves_before_barrier", 2, 64, leaves_before_barrier, 64u));
    CHECK_NOTHROW(Executor().launch("leaves_before_barrier", 2, 64, leaves_before_barrier, 0u));
}

TEST_CASE("executor: coming to the kernel's end before a barrier is an error",
          "[simt][divergence]") {
    const LaunchError error =
        error_of([] { Executor().launch("ends_before_barrier", 1, 4, ends_before_barrier); });
    CHECK_THAT(error.what(), EndsWith("threads 1, 3 have left the kernel at its end"));
    const LaunchError after =
        error_of([] { Executor().launch("ends_after_call", 1, 32, ends_after_call); });
    CHECK_THAT(after.what(), ContainsSubstring("thread 7 has left the kernel at its end"));
}

TEST_CASE("executor: a warp collective reached by part of the warp is an error",
          "[simt][divergence]") {
    std::uint32_t out = 0;
    for (const SimtOptions& options : every_order()) {
        Executor executor(options);
        const LaunchError left = error_of(
            [&] { executor.launch("leaves_before_ballot", 1, 64, leaves_before_ballot, &out); });
        CHECK_THAT(left.what(),
                   ContainsSubstring("threads 3, 35 have left the kernel") &&
                       ContainsSubstring("threads 0-2, 4-34, 36-63 wait at the warp collective"));
        const LaunchError half = error_of(
            [&] { executor.launch("half_a_warp_ballots", 1, 64, half_a_warp_ballots, &out); });
        CHECK_THAT(half.what(),
                   ContainsSubstring("threads 0-15, 32-47 wait at the warp collective") &&
                       ContainsSubstring("threads 16-31, 48-63 wait at the barrier"));
        const LaunchError two =
            error_of([&] { executor.launch("two_ballots", 1, 32, two_ballots, &out); });
        REQUIRE(two.groups.size() == 2);
        CHECK(two.groups[0].stop->line + 2 == two.groups[1].stop->line);
    }
    CHECK(out == 0);
}

TEST_CASE("executor: turns of a loop with a barrier that differ between warps are an error",
          "[simt][divergence]") {
    CHECK_NOTHROW(Executor().launch("uneven_loop", 1, 32, uneven_loop));
    CHECK_THROWS_AS(Executor().launch("uneven_loop", 1, 64, uneven_loop), LaunchError);
}

TEST_CASE("executor: one barrier reached by two calls is one place", "[simt][divergence]") {
    CHECK_NOTHROW(Executor().launch("two_calls", 1, 64, two_calls));
}

TEST_CASE("executor: a thread that throws ends its block and is named", "[simt][failure]") {
    for (const SimtOptions& options : every_order()) {
        std::uint32_t after = 0;
        Executor executor(options);
        const LaunchError error =
            error_of([&] { executor.launch("throws", 4, 64, throws, 2u, 33u, &after); });
        CHECK(std::string(error.what()) ==
              "kernel throws, block 2 (64 threads): thread 33 failed: no such luck");
        CHECK(error.block == 2);
        CHECK(after == 0);
        // The executor is still usable.
        executor.launch("throws", 4, 64, throws, 9u, 33u, &after);
    }
}

TEST_CASE("executor: contracts that break in a collective function name kernel and thread",
          "[simt][failure]") {
    const LaunchError error = error_of([] { Executor().launch("asserts", 1, 64, asserts); });
    CHECK_THAT(error.what(), ContainsSubstring("kernel asserts, block 0") &&
                                 ContainsSubstring("thread 40 failed") &&
                                 ContainsSubstring("value < 40u (40 vs 40)"));
    const LaunchError odd =
        error_of([] { Executor().launch("throws_at_once", 1, 64, throws_at_once); });
    CHECK_THAT(odd.what(), ContainsSubstring("thread 5 failed: an exception of unknown type"));
}

TEST_CASE("executor: a thread that reaches memory which is not there ends its launch, and is named",
          "[simt][failure]") {
    const NobodyAnswersSignals as_outside_tests;
    for (const SimtOptions& options : every_order()) {
        Executor executor(options);
        for (int again = 0; again < 2; ++again) {
            const LaunchError error = error_of(
                [&] { executor.launch("writes_nowhere", 4, 64, writes_nowhere, nowhere()); });
            CHECK(error.what() ==
                  std::string("kernel writes_nowhere, block 2 (64 threads): thread 33 reached "
                              "memory that is not there; --check names the line"));
        }
        // The executor is still usable.
        std::uint32_t there = 0;
        executor.launch("writes_nowhere", 4, 64, writes_nowhere, &there);
        CHECK(there == 1);
    }
}

TEST_CASE("executor: a bad address outside kernels ends the process", "[simt][failure]") {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        const NobodyAnswersSignals as_outside_tests;
        std::uint32_t there = 0;
        Executor({0, ScheduleKind::linear, 0})
            .launch("writes_nowhere", 4, 64, writes_nowhere, &there);
        ::raise(SIGSEGV);
        _exit(0);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGSEGV);
}

TEST_CASE("executor: thread lists are short", "[simt]") {
    CHECK(thread_list({}).empty());
    CHECK(thread_list({4}) == "4");
    CHECK(thread_list({4, 5}) == "4, 5");
    CHECK(thread_list({0, 1, 2, 5, 7, 8, 9, 31}) == "0-2, 5, 7-9, 31");
}

TEST_CASE("runtime: a failed launch is told once, and fails what is not asked", "[simt][runtime]") {
    Executor executor;
    const scotty::emulation::simt::CurrentDevice here(executor);
    CHECK(cudaGetLastError() == cudaSuccess);
    cudaStream_t stream = nullptr;
    REQUIRE(cudaStreamCreate(&stream) == cudaSuccess);
    SCOTTY_LAUNCH(ends_before_barrier, 1, 4, stream);
    SCOTTY_LAUNCH(two_calls, 1, 64, stream);  // does not hide the error
    std::uint32_t from = 1;
    std::uint32_t to = 0;
    CHECK(cudaMemcpy(&to, &from, 4, cudaMemcpyHostToDevice) == cudaErrorLaunchFailure);
    CHECK(cudaStreamSynchronize(stream) == cudaErrorLaunchFailure);
    CHECK(to == 0);
    const auto status = cudaGetLastError();
    CHECK(status == cudaErrorLaunchFailure);
    CHECK_THAT(cudaGetErrorString(status),
               ContainsSubstring("kernel ends_before_barrier, block 0"));
    CHECK(cudaGetLastError() == cudaSuccess);
    CHECK(cudaMemcpy(&to, &from, 4, cudaMemcpyHostToDevice) == cudaSuccess);
    CHECK(to == 1);
    CHECK(cudaStreamDestroy(stream) == cudaSuccess);
}

TEST_CASE("runtime: a launch without an executor is an error", "[simt][runtime]") {
    SCOTTY_LAUNCH(two_calls, 1, 64, nullptr);
    const auto status = cudaGetLastError();
    CHECK_THAT(cudaGetErrorString(status), ContainsSubstring("no executor is current"));
}

TEST_CASE("runtime: device memory is poisoned, aligned, and checked for null", "[simt][runtime]") {
    void* memory = nullptr;
    REQUIRE(cudaMalloc(&memory, 1000) == cudaSuccess);
    CHECK(reinterpret_cast<std::uintptr_t>(memory) % 256 == 0);
    std::uint32_t words[2];
    CHECK(cudaMemcpy(words, memory, 8, cudaMemcpyDeviceToHost) == cudaSuccess);
    CHECK(words[0] == 0xcdcdcdcd);
    CHECK(cudaMemset(memory, 0, 4) == cudaSuccess);
    CHECK(cudaMemcpy(words, memory, 8, cudaMemcpyDeviceToHost) == cudaSuccess);
    CHECK(words[0] == 0);
    CHECK(words[1] == 0xcdcdcdcd);
    CHECK(cudaMemcpy(memory, nullptr, 8, cudaMemcpyHostToDevice) == cudaErrorInvalidValue);
    CHECK(cudaMemset(nullptr, 0, 8) == cudaErrorInvalidValue);
    CHECK(cudaFree(memory) == cudaSuccess);
    CHECK(cudaMalloc(&memory, std::size_t{1} << 60) == cudaErrorMemoryAllocation);
    CHECK(std::string(cudaGetErrorName(cudaErrorMemoryAllocation)) == "cudaErrorMemoryAllocation");
    CHECK(cudaMalloc(&memory, 0) == cudaSuccess);
    CHECK(memory == nullptr);
}

}  // namespace
