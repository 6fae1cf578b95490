/// Warp collectives and the block scan.
#include "tests/properties.h"

#include "gpu/kernels/block_scan.h"
#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

SCOTTY_KERNEL(ballots)(std::uint32_t rounds, std::uint32_t* out) {
    std::uint32_t mixed = thread_index();
    for (std::uint32_t round = 0; round < rounds; ++round) {
        const std::uint32_t ballot = SCOTTY_AWAIT(warp_ballot((mixed >> round & 1u) != 0));
        out[round * block_size() + thread_index()] = ballot;
        mixed ^= ballot;
    }
}

/// Two calls in a row: the second must see nothing of the first.
SCOTTY_KERNEL(many_ballots)(const std::uint32_t* bits, std::uint32_t* out) {
    const std::uint32_t mine = bits[thread_index()];
    const auto first = SCOTTY_AWAIT(warp_ballots<16>(mine));
    const auto second = SCOTTY_AWAIT(warp_ballots<5>(mine >> 16));
    for (std::uint32_t i = 0; i < 16; ++i) out[21 * thread_index() + i] = first.of[i];
    for (std::uint32_t i = 0; i < 5; ++i) out[21 * thread_index() + 16 + i] = second.of[i];
}

SCOTTY_KERNEL(ballot_in_one_warp)(std::uint32_t* out) {
    std::uint32_t ballot = 0;
    if (warp_index() == 1) ballot = SCOTTY_AWAIT(warp_ballot(lane_index() % 2 == 0));
    SCOTTY_SYNC();
    out[thread_index()] = count_bits(bits_below_lane(ballot));
}

SCOTTY_KERNEL(shuffles)(std::uint32_t delta, std::uint32_t* out) {
    const std::uint32_t once = SCOTTY_AWAIT(warp_shuffle_up(thread_index(), delta));
    out[thread_index()] = SCOTTY_AWAIT(warp_shuffle_up(once, delta));
}

SCOTTY_KERNEL(scan)(const std::uint32_t* in, std::uint32_t* ranks, std::uint32_t* totals) {
    SCOTTY_SHARED(BlockScanShared, shared);
    const std::uint32_t i = block_index() * block_size() + thread_index();
    const BlockRank once = SCOTTY_AWAIT(block_exclusive_scan(in[i], shared));
    const BlockRank twice = SCOTTY_AWAIT(block_exclusive_scan(in[i], shared));
    ranks[i] = once.rank == twice.rank ? once.rank : 0xffffffffu;
    totals[i] = once.total;
}

SCOTTY_KERNEL(counters)(std::uint32_t* words, std::uint64_t* least, float* nearest) {
    const std::uint32_t i = block_index() * block_size() + thread_index();
    const std::uint32_t before = atomic_add(&words[0], 1);
    atomic_max(&words[1], before + 1);
    atomic_min(least, std::uint64_t{1} << 40 | (i ^ 77));
    atomic_min_distance(nearest, 1.0f + static_cast<float>(i));
    if (i == 500) atomic_min_distance(nearest, -1.0f);
    atomic_add(&words[2 + before], 1);  // each thread has its own value before
    atomic_add(&words[2 + 1024], load_relaxed(nearest) <= 1e9f ? 1 : 0);
    words[2 + 1025 + i] = float_bits(bits_float(i));
    SCOTTY_RETURN;
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;

TEST_CASE("executor: a ballot has a bit for every lane of the warp and no other",
          "[simt][collective]") {
    for (const std::uint32_t threads : {32u, 64u, 70u, 1024u}) {
        for (const SimtOptions& options : every_order()) {
            std::vector<std::uint32_t> out(5 * threads, 0);
            Executor(options).launch("ballots", 1, threads, ballots, 5u, out.data());
            std::vector<std::uint32_t> mixed(threads);
            for (std::uint32_t i = 0; i < threads; ++i) mixed[i] = i;
            for (std::uint32_t round = 0; round < 5; ++round) {
                std::vector<std::uint32_t> ballot((threads + 31) / 32, 0);
                for (std::uint32_t i = 0; i < threads; ++i) {
                    ballot[i / 32] |= (mixed[i] >> round & 1u) << i % 32;
                }
                for (std::uint32_t i = 0; i < threads; ++i) {
                    CHECK(out[round * threads + i] == ballot[i / 32]);
                    mixed[i] ^= ballot[i / 32];
                }
            }
        }
    }
}

TEST_CASE("executor: many ballots at once are what they are one by one", "[simt][collective]") {
    for (const std::uint32_t threads : {64u, 70u}) {
        for (const SimtOptions& options : every_order()) {
            std::vector<std::uint32_t> bits(threads);
            for (std::uint32_t i = 0; i < threads; ++i) bits[i] = 0x9e3779b9u * (i + 1);
            std::vector<std::uint32_t> out(21 * threads, 0);
            Executor(options).launch("many_ballots", 1, threads, many_ballots, bits.data(),
                                     out.data());
            for (std::uint32_t i = 0; i < threads; ++i) {
                for (std::uint32_t bit = 0; bit < 21; ++bit) {
                    std::uint32_t ballot = 0;
                    for (std::uint32_t lane = 0; lane < 32 && i / 32 * 32 + lane < threads;
                         ++lane) {
                        ballot |= (bits[i / 32 * 32 + lane] >> bit & 1u) << lane;
                    }
                    CHECK(out[21 * i + bit] == ballot);
                }
            }
        }
    }
}

TEST_CASE("executor: one warp may ballot while the others wait at the barrier",
          "[simt][collective]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> out(96, 0);
        Executor(options).launch("ballot_in_one_warp", 1, 96, ballot_in_one_warp, out.data());
        for (std::uint32_t i = 0; i < 96; ++i) {
            CHECK(out[i] == (i / 32 == 1 ? (i % 32 + 1) / 2 : 0));
        }
    }
}

TEST_CASE("executor: a shuffle brings the value of the lane below, or the lane's own",
          "[simt][collective]") {
    for (const SimtOptions& options : every_order()) {
        for (const std::uint32_t delta : {0u, 1u, 2u, 7u, 16u, 31u}) {
            std::vector<std::uint32_t> out(64, 0);
            Executor(options).launch("shuffles", 1, 64, shuffles, delta, out.data());
            const auto below = [&](std::uint32_t i) { return i % 32 < delta ? i : i - delta; };
            for (std::uint32_t i = 0; i < 64; ++i) CHECK(out[i] == below(below(i)));
        }
    }
}

TEST_CASE("block_scan: ranks are exclusive sums, for 32 to 1024 threads", "[simt][scan]") {
    scotty::tests::check_property("whatever the values and the order", [] {
        const std::uint32_t threads = 32 * *rc::gen::inRange(1u, 33u);
        const std::uint32_t blocks = *rc::gen::inRange(1u, 4u);
        const auto in = *rc::gen::container<std::vector<std::uint32_t>>(
            blocks * threads, rc::gen::inRange(0u, 1u << 20));
        const auto order = *rc::gen::elementOf(every_order());
        std::vector<std::uint32_t> ranks(in.size(), 0);
        std::vector<std::uint32_t> totals(in.size(), 0);
        Executor(order).launch("scan", blocks, threads, scan, in.data(), ranks.data(),
                               totals.data());
        for (std::uint32_t block = 0; block < blocks; ++block) {
            std::uint32_t sum = 0;
            for (std::uint32_t i = block * threads; i < (block + 1) * threads; ++i) {
                RC_ASSERT(ranks[i] == sum);
                sum += in[i];
            }
            RC_ASSERT(totals[block * threads] == sum);
            RC_ASSERT(totals[(block + 1) * threads - 1] == sum);
        }
    });
}

TEST_CASE("executor: atomics of 32 and 64 bits lose nothing", "[simt][atomics]") {
    for (const SimtOptions& options : every_order()) {
        std::vector<std::uint32_t> words(2 + 1025 + 1024, 0);
        std::uint64_t least = ~std::uint64_t{0};
        float nearest = 1e9f;
        Executor(options).launch("counters", 16, 64, counters, words.data(), &least, &nearest);
        CHECK(words[0] == 1024);
        CHECK(words[1] == 1024);
        CHECK(least == std::uint64_t{1} << 40);
        CHECK(nearest == -1.0f);
        for (std::uint32_t i = 0; i < 1024; ++i) {
            CHECK(words[2 + i] == 1);
            CHECK(words[2 + 1025 + i] == i);
        }
        CHECK(words[2 + 1024] == 1024);
    }
}

}  // namespace
