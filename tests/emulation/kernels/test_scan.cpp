/// Scans, and how blocks find their nodes in them.
#include "tests/properties.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "emulation/kernels/intersect.h"
#include "emulation/kernels/scan_counts.h"
#include "tests/catch.h"

using namespace scotty::emulation;
using Counts = std::vector<std::uint32_t>;

namespace {

Counts host_scan(const Counts& values) {
    Counts sums(values.size() + 1, 0);
    std::partial_sum(values.begin(), values.end(), sums.begin() + 1);
    return sums;
}

Counts random_counts(std::size_t size, std::uint32_t most, std::uint32_t seed) {
    std::mt19937 random(seed);
    Counts counts(size);
    for (std::uint32_t& n : counts) {
        // Half of them are empty, as on deep levels.
        n = random() % 2 == 0 ? 0 : static_cast<std::uint32_t>(random() % (most + 1));
    }
    return counts;
}

/// Exclusive scan of blocks per node, as scan_counts computes it.
Counts block_offsets_of(const Counts& counts, std::uint32_t threads) {
    Counts blocks(counts.size());
    std::transform(counts.begin(), counts.end(), blocks.begin(),
                   [&](std::uint32_t n) { return (n + threads - 1) / threads; });
    return host_scan(blocks);
}

/// Whether every block finds the node whose range of blocks it lies in.
bool all_blocks_find_their_node(const Counts& offsets, std::uint32_t threads) {
    const auto nodes = static_cast<std::uint32_t>(offsets.size() - 1);
    for (std::uint32_t id = 0; id < offsets.back(); ++id) {
        const std::uint32_t node = find_node(Block(id, threads), offsets.data(), nodes, id);
        if (node >= nodes || !(offsets[node] <= id && id < offsets[node + 1])) return false;
    }
    return true;
}

}  // namespace

TEST_CASE("scan: equals a host scan for every size, zeros included", "[emulation][scan]") {
    constexpr std::uint32_t kCanary = 0xdeadbeefu;
    for (const std::uint32_t threads : {32u, 256u, 1024u}) {
        for (const std::size_t size : {0, 1, 2, 31, 255, 256, 257, 1024, 2048, 2049, 100000}) {
            const Counts values = random_counts(size, 1000, 1);
            Counts out(size + 2, kCanary);
            block_exclusive_scan(
                Block(0, threads), static_cast<std::uint32_t>(size),
                [&](std::uint32_t i) { return values.at(i); }, out.data());
            INFO("size " << size << ", threads " << threads);
            CHECK(out.back() == kCanary);
            out.pop_back();
            CHECK(out == host_scan(values));
        }
    }
}

TEST_CASE("scan: blocks are queue lengths over rays per block, rounded up", "[emulation][scan]") {
    const Counts counts{0, 1, 63, 64, 65, 0, 640};
    const Counts parents{1, 1, 3, 6};
    Counts block_offsets(counts.size() + 1);
    Counts child_offsets(parents.size() + 1);
    scan_counts(Block(0, kScanThreads), {7, counts.data(), 4, parents.data(), 64,
                                         block_offsets.data(), child_offsets.data()});
    CHECK(block_offsets == Counts{0, 0, 1, 2, 3, 5, 5, 15});
    // A child's region is as long as its parent's queue.
    CHECK(child_offsets == Counts{0, 1, 2, 66, 706});
}

TEST_CASE("scan: an empty level yields no blocks", "[emulation][scan]") {
    const Counts counts(300, 0);
    const Counts parents(10, 5);
    Counts block_offsets(301, 7);
    Counts child_offsets(11, 7);
    scan_counts(Block(0, kScanThreads), {300, counts.data(), 10, parents.data(), 64,
                                         block_offsets.data(), child_offsets.data()});
    CHECK(block_offsets == Counts(301, 0));
    CHECK(child_offsets == Counts(11, 0));
}

TEST_CASE("scan: the last level has no children", "[emulation][scan]") {
    const Counts counts{5, 6};
    Counts block_offsets(3, 7);
    Counts child_offsets(1, 7);
    scan_counts(Block(0, kScanThreads),
                {2, counts.data(), 0, nullptr, 32, block_offsets.data(), child_offsets.data()});
    CHECK(block_offsets == Counts{0, 1, 2});
    CHECK(child_offsets == Counts{0});
}

TEST_CASE("search: every block finds its node, for every rays per block", "[emulation][scan]") {
    scotty::tests::check_property("random queues", [](std::uint32_t seed) {
        const std::size_t nodes = *rc::gen::inRange<std::size_t>(1, 3000);
        const Counts counts = random_counts(nodes, 300, seed);
        const std::uint32_t threads = 32 * *rc::gen::inRange(1u, 33u);
        RC_ASSERT(all_blocks_find_their_node(block_offsets_of(counts, threads), threads));
    });
}

TEST_CASE("search: one node, empty nodes at both ends, and more nodes than the report allowed",
          "[emulation][scan]") {
    for (std::uint32_t threads = 32; threads <= 1024; threads += 32) {
        INFO("rays per block " << threads);
        CHECK(all_blocks_find_their_node(block_offsets_of({5000}, threads), threads));
        CHECK(all_blocks_find_their_node(block_offsets_of({0, 0, 3, 0, 0, 9000, 0}, threads),
                                         threads));
        for (const std::size_t nodes : {threads - 1, threads, threads + 1, 7001u}) {
            CHECK(all_blocks_find_their_node(
                block_offsets_of(random_counts(nodes, 100, threads), threads), threads));
        }
    }
    // The search takes three rounds.
    CHECK(all_blocks_find_their_node(block_offsets_of(random_counts(40000, 60, 3), 32), 32));
}

TEST_CASE("search: the check of the search can fail", "[emulation][scan]") {
    Counts offsets = block_offsets_of({40, 40, 40}, 32);
    offsets[1] = offsets[2];  // node 0 now claims node 1's blocks
    offsets[2] = offsets[1] - 1;
    CHECK_FALSE(all_blocks_find_their_node(offsets, 32));
}

TEST_CASE("grid: the strided order is a permutation of all blocks", "[emulation][scan]") {
    for (std::uint32_t side = 1; side <= 40; ++side) {
        std::set<std::uint32_t> seen;
        for (std::uint32_t launched = 0; launched < side * side; ++launched) {
            seen.insert(logical_block(launched, side));
        }
        CHECK(seen.size() == side * side);
        CHECK(*seen.rbegin() == side * side - 1);
    }
    CHECK(logical_block(17, 0) == 17);  // linear
    CHECK(logical_block(1, 10) == 10);  // neighbours in launch order are a row apart
}

TEST_CASE("grid: blocks share out every queue entry exactly once", "[emulation][scan]") {
    scotty::tests::check_property("linear and strided", [](std::uint32_t seed) {
        const std::size_t nodes = *rc::gen::inRange<std::size_t>(1, 50);
        const Counts counts = random_counts(nodes, 500, seed);
        const std::uint32_t threads = 32 * *rc::gen::inRange(1u, 33u);
        const Counts offsets = block_offsets_of(counts, threads);
        LevelView level{};
        level.node_count = static_cast<std::uint32_t>(nodes);
        level.node_counts = counts.data();
        level.block_offsets = offsets.data();
        std::uint32_t side = 0;
        while (side * side < offsets.back()) ++side;
        for (const std::uint32_t grid : {0u, side}) {
            std::vector<Counts> visits;
            for (const std::uint32_t n : counts) visits.emplace_back(n, 0);
            const std::uint32_t launched = grid == 0 ? offsets.back() : grid * grid;
            for (std::uint32_t id = 0; id < launched; ++id) {
                const BlockWork work = find_work(Block(id, threads), level, grid);
                if (work.node == scotty::reference::kNone) continue;
                RC_ASSERT((work.count >= 1 && work.count <= threads));
                for (std::uint32_t i = 0; i < work.count; ++i) {
                    ++visits.at(work.node).at(work.first + i);
                }
            }
            for (std::size_t n = 0; n < nodes; ++n) RC_ASSERT(visits[n] == Counts(counts[n], 1));
        }
    });
}
