/// Barriers wherever they are allowed, and shared memory between them.
#include <numeric>

#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

/// Every thread reads the value that its neighbour wrote before the barrier, round after round.
SCOTTY_KERNEL(pass_around)(std::uint32_t rounds, std::uint32_t* out) {
    struct Values {
        std::uint32_t value[1024];
    };
    SCOTTY_SHARED(Values, shared);
    std::uint32_t mine = thread_index() + 1000 * block_index();
    for (std::uint32_t round = 0; round < rounds; ++round) {
        shared.value[thread_index()] = mine;
        SCOTTY_SYNC();
        mine = shared.value[(thread_index() + 1) % block_size()];
        SCOTTY_SYNC();
    }
    out[block_index() * block_size() + thread_index()] = mine;
}

/// A barrier in a branch that the whole block takes or leaves.
SCOTTY_KERNEL(branch_by_block)(std::uint32_t* out) {
    SCOTTY_SHARED(std::uint32_t, sum);
    if (thread_index() == 0) sum = 0;
    SCOTTY_SYNC();
    if (block_index() % 2 == 0) {
        atomic_add(&sum, thread_index());
        SCOTTY_SYNC();
    } else {
        atomic_add(&sum, 1);
        SCOTTY_SYNC();
        if (thread_index() == 0) atomic_add(&sum, 100);
        SCOTTY_SYNC();
    }
    if (thread_index() == block_size() - 1) out[block_index()] = sum;
}

SCOTTY_COLLECTIVE(std::uint32_t) reverse(std::uint32_t value, std::uint32_t* shared) {
    shared[thread_index()] = value;
    SCOTTY_SYNC();
    const std::uint32_t other = shared[block_size() - 1 - thread_index()];
    SCOTTY_SYNC();
    SCOTTY_RETURN other;
}
SCOTTY_COLLECTIVE(std::uint32_t) reverse_twice(std::uint32_t value, std::uint32_t* shared) {
    const std::uint32_t once = SCOTTY_AWAIT(reverse(value, shared));
    SCOTTY_RETURN SCOTTY_AWAIT(reverse(once, shared)) + (once << 16);
}
SCOTTY_COLLECTIVE(void) store(std::uint32_t value, std::uint32_t* to) {
    *to = value;
    SCOTTY_SYNC();
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(nested)(std::uint32_t* out) {
    struct Values {
        std::uint32_t value[256];
    };
    SCOTTY_SHARED(Values, shared);
    const std::uint32_t result = SCOTTY_AWAIT(reverse_twice(thread_index(), shared.value));
    SCOTTY_AWAIT(store(result, out + thread_index()));
}

SCOTTY_KERNEL(two_shared)(std::uint32_t* out) {
    SCOTTY_SHARED(std::uint32_t, a);
    SCOTTY_SHARED(std::uint64_t, b);
    if (thread_index() == 0) {
        out[0] = a;  // unwritten
        a = 1;
        b = 2;
    }
    SCOTTY_SYNC();
    if (thread_index() == 1) {
        out[1] = a;
        out[2] = static_cast<std::uint32_t>(b);
        out[3] = reinterpret_cast<std::uintptr_t>(&b) % alignof(std::uint64_t) == 0 ? 1 : 0;
    }
}

SCOTTY_KERNEL(too_much_shared)() {
    struct Huge {
        char bytes[64 << 10];
    };
    SCOTTY_SHARED(Huge, huge);
    huge.bytes[0] = 1;
    SCOTTY_SYNC();
}

SCOTTY_KERNEL(no_barrier)(std::uint32_t count, std::uint32_t* out) {
    const std::uint32_t i = block_index() * block_size() + thread_index();
    if (i >= count) SCOTTY_RETURN;
    atomic_add(&out[i], i + grid_size());
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;

TEST_CASE("executor: what threads write before a barrier, all read after it", "[simt][barrier]") {
    for (const std::uint32_t threads : {1u, 2u, 31u, 32u, 33u, 64u, 100u, 256u, 1024u}) {
        for (const SimtOptions& options : every_order()) {
            Executor executor(options);
            std::vector<std::uint32_t> out(3 * threads, 0);
            executor.launch("pass_around", 3, threads, pass_around, 5u, out.data());
            for (std::uint32_t i = 0; i < out.size(); ++i) {
                CHECK(out[i] == (i % threads + 5) % threads + 1000 * (i / threads));
            }
            CHECK(executor.threads_run() == 3 * threads);
        }
    }
}

TEST_CASE("executor: barriers in branches that a block takes together", "[simt][barrier]") {
    for (const SimtOptions& options : every_order()) {
        Executor executor(options);
        std::vector<std::uint32_t> out(9, 0);
        executor.launch("branch_by_block", 9, 96, branch_by_block, out.data());
        for (std::size_t block = 0; block < out.size(); ++block) {
            CHECK(out[block] == (block % 2 == 0 ? 96 * 95 / 2 : 196));
        }
    }
}

TEST_CASE("executor: functions with barriers call each other and return values",
          "[simt][barrier]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> out(256, 0);
        Executor(options).launch("nested", 1, 256, nested, out.data());
        for (std::uint32_t i = 0; i < 256; ++i) CHECK(out[i] == i + ((255 - i) << 16));
    }
}

TEST_CASE("executor: shared objects are apart, aligned, and poisoned until written",
          "[simt][shared]") {
    Executor executor;
    for (int round = 0; round < 2; ++round) {
        std::vector<std::uint32_t> out(4, 0);
        executor.launch("two_shared", 1, 64, two_shared, out.data());
        CHECK(out == std::vector<std::uint32_t>{0xcdcdcdcd, 1, 2, 1});
    }
}

TEST_CASE("executor: more shared memory than a block has is an error", "[simt][shared]") {
    const LaunchError error =
        error_of([] { Executor().launch("too_much_shared", 1, 32, too_much_shared); });
    CHECK_THAT(error.what(), Catch::Matchers::ContainsSubstring("48 KiB"));
}

TEST_CASE("executor: a kernel without barriers runs every thread once, and may leave early",
          "[simt]") {
    for (const SimtOptions& options : every_order()) {
        Executor executor(options);
        std::vector<std::uint32_t> out(1000, 0);
        executor.launch("no_barrier", 4, 256, no_barrier, 1000u, out.data());
        for (std::uint32_t i = 0; i < out.size(); ++i) CHECK(out[i] == i + 4);
        CHECK(executor.threads_run() == 1024);
    }
}

TEST_CASE("executor: a launch of no blocks, no threads or too many is an error", "[simt]") {
    Executor executor;
    std::uint32_t out = 0;
    for (const auto& [blocks, threads] : {std::pair{0u, 32u}, {1u, 0u}, {1u, 1025u}}) {
        CHECK_THROWS_WITH(executor.launch("no_barrier", blocks, threads, no_barrier, 1u, &out),
                          Catch::Matchers::ContainsSubstring("kernel no_barrier: a launch of") &&
                              Catch::Matchers::ContainsSubstring("1 to 1024"));
    }
    CHECK(out == 0);
}

}  // namespace
