/// The level kernel on inner nodes: which rays it pushes, where to, and what it leaves alone.
#include "tests/properties.h"

#include "tests/catch.h"
#include "tests/emulation/one_level.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using scotty::reference::EarlyOut;

namespace {

/// Checks that everything outside the filled part of every child's region is unchanged.
template <int Width>
bool rest_is_untouched(const OneLevel<Width>& level) {
    std::vector<bool> filled(level.child_queue.size(), false);
    for (std::size_t child = 0; child < level.parents.size(); ++child) {
        for (std::uint32_t i = 0; i < level.child_counts[child]; ++i) {
            filled[level.child_offsets[child] + i] = true;
        }
    }
    for (std::size_t i = 0; i < filled.size(); ++i) {
        if (!filled[i] && level.child_queue[i] != kPoison) return false;
    }
    return true;
}

template <int Width>
void check_level(const std::vector<std::uint32_t>& lengths, std::uint32_t threads,
                 ScheduleKind schedule, bool culls, std::uint32_t seed) {
    OneLevel<Width> level(lengths, seed);
    if (culls) {
        for (float& m : level.minimum) m = scotty::reference::test::uniform(level.random, 0, 2);
        level.minimum[3] = kDone;
    }
    Device device({2, schedule, seed});
    std::uint32_t side = 0;
    for (int grid = 0; grid < 2; ++grid) {
        level.scan(threads);
        if (grid == 1) {
            while (side * side < level.block_offsets.back()) ++side;
        }
        level.run(device, threads, culls ? EarlyOut::level : EarlyOut::off, side);
        const auto expected = level.pushed();
        INFO("width " << Width << ", " << threads << " rays per block, seed " << seed);
        CHECK(level.overflow == 0);
        CHECK(rest_is_untouched(level));
        for (std::size_t child = 0; child < expected.size(); ++child) {
            CHECK(sorted(level.queue_of(child)) == sorted(expected[child]));
            // One block after the other keeps the input's order too.
            if (schedule == ScheduleKind::linear && grid == 0) {
                CHECK(level.queue_of(child) == expected[child]);
            }
        }
    }
}

}  // namespace

TEST_CASE("intersect: pushes exactly what a straight loop pushes, for odd queue lengths",
          "[emulation][intersect]") {
    for (const std::uint32_t threads : {32u, 64u, 256u, 1024u}) {
        const std::vector<std::uint32_t> lengths{1,           31,          0, 33,         threads,
                                                 threads + 1, 3 * threads, 0, threads - 1};
        check_level<2>(lengths, threads, ScheduleKind::linear, false, threads);
        check_level<4>(lengths, threads, ScheduleKind::free, false, threads);
        check_level<8>(lengths, threads, ScheduleKind::reversed, true, threads);
        check_level<16>(lengths, threads, ScheduleKind::shuffled, true, threads);
    }
}

TEST_CASE("intersect: pushes exactly what a straight loop pushes, for random levels",
          "[emulation][intersect]") {
    scotty::tests::check_property("random levels", [](std::uint32_t seed) {
        const auto lengths = *rc::gen::container<std::vector<std::uint32_t>>(
            1 + seed % 5, rc::gen::inRange(0u, 200u));
        const std::uint32_t threads = 32 * *rc::gen::inRange(1u, 9u);
        check_level<4>(lengths, threads, ScheduleKind::linear, seed % 2 == 0, seed);
        check_level<8>(lengths, threads, ScheduleKind::free, seed % 2 == 1, seed);
    });
}

TEST_CASE("intersect_root: ray ids are thread ids, for every tail", "[emulation][intersect]") {
    for (const std::uint32_t count : {1u, 31u, 33u, 64u, 65u, 500u}) {
        OneLevel<8> level({count}, count);
        // The root is node 0, and its queue is all rays in order.
        for (std::uint32_t i = 0; i < count; ++i) level.queue[i] = i;
        level.scan(64);
        LevelView view = level.view();
        view.queue = nullptr;
        view.queue_offsets = nullptr;
        Device device({1, ScheduleKind::linear, 0});
        device.launch(level.block_offsets.back(), 64, [&](const Block& block) {
            intersect_root(block, level.bvh(), level.rays.data(), count, view,
                           level.minimum_view(EarlyOut::off));
        });
        const auto expected = level.pushed();
        for (std::size_t child = 0; child < expected.size(); ++child) {
            CHECK(level.queue_of(child) == expected[child]);
        }
        CHECK(rest_is_untouched(level));
    }
}

TEST_CASE("intersect: a missing child gets nothing", "[emulation][intersect]") {
    OneLevel<4> level({40}, 1);
    level.scan(32);
    auto& node = level.inner[0];
    std::uint32_t missing = kNone;
    for (std::uint32_t& child : node.child) {
        if (child == kNone) continue;
        missing = child - level.first_child();
        child = kNone;  // its box stays where rays go
        break;
    }
    Device device({1, ScheduleKind::linear, 0});
    level.run(device, 32, EarlyOut::off);
    CHECK(level.child_counts.at(missing) == 0);
    CHECK(rest_is_untouched(level));
}

TEST_CASE("intersect: dead rays and rays that are done never enter a child",
          "[emulation][intersect]") {
    OneLevel<8> level({500}, 2);
    for (std::uint32_t i = 0; i < 500; ++i) level.queue[i] = i;
    for (std::size_t i = 1; i < 500; i += 2) level.minimum[i] = kDone;
    level.scan(64);
    Device device({2, ScheduleKind::free, 0});
    level.run(device, 64, EarlyOut::immediate);
    std::size_t entered = 0;
    for (std::size_t child = 0; child < level.parents.size(); ++child) {
        for (const std::uint32_t id : level.queue_of(child)) {
            CHECK_FALSE(scotty::reference::is_dead(level.rays[id]));
            CHECK(id % 2 == 0);
            ++entered;
        }
    }
    CHECK(entered > 50);
}

TEST_CASE("intersect: a region that is too small is reported and nothing leaves its region",
          "[emulation][intersect]") {
    for (const ScheduleKind schedule : {ScheduleKind::linear, ScheduleKind::free}) {
        OneLevel<8> level({2000, 2000}, 3);
        const auto expected = level.pushed();
        level.scan(32);
        // Every region has the size it needs, except one that lacks a slot.
        std::size_t tight = 0;
        while (expected[tight].size() < 40) ++tight;
        for (std::size_t child = tight + 1; child < level.child_offsets.size(); ++child) {
            const std::uint32_t room = static_cast<std::uint32_t>(expected[tight].size()) - 1;
            level.child_offsets[child] -= 2000 - room;
        }
        Device device({2, schedule, 0});
        level.run(device, 32, EarlyOut::off);
        CHECK(level.overflow == level.first_child() + tight + 1);  // node id + 1
        CHECK(level.child_counts[tight] == expected[tight].size());
        for (std::size_t child = 0; child < expected.size(); ++child) {
            if (child != tight) CHECK(sorted(level.queue_of(child)) == sorted(expected[child]));
        }
        // The entries that fit are the node's own; the block that did not fit wrote nothing.
        for (std::uint32_t i = level.child_offsets[tight]; i < level.child_offsets[tight + 1];
             ++i) {
            const std::uint32_t id = level.child_queue[i];
            if (id == kPoison) continue;
            CHECK(std::count(expected[tight].begin(), expected[tight].end(), id) > 0);
        }
    }
}
