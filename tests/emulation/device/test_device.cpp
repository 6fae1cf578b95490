/// The virtual device: blocks, phases, schedules, memory.
#include <algorithm>
#include <atomic>
#include <numeric>
#include <vector>

#include "emulation/device/device.h"
#include "emulation/device/device_buffer.h"
#include "tests/catch.h"

using namespace scotty::emulation;

namespace {

/// The order in which an explicit schedule runs the blocks of one launch.
std::vector<std::uint32_t> order_of(Device& device, std::uint32_t blocks) {
    std::vector<std::uint32_t> order;
    device.launch(blocks, 32, [&](const Block& block) { order.push_back(block.index()); });
    return order;
}

std::vector<std::uint32_t> ascending(std::uint32_t count) {
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

}  // namespace

TEST_CASE("device: every block runs exactly once, under every schedule and thread count",
          "[emulation][device]") {
    for (const ScheduleKind schedule :
         {ScheduleKind::free, ScheduleKind::linear, ScheduleKind::reversed, ScheduleKind::strided,
          ScheduleKind::shuffled, ScheduleKind::adversarial}) {
        for (const std::size_t workers : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
            Device device({workers, schedule, 5});
            for (const std::uint32_t blocks : {0u, 1u, 2u, 7u, 1000u}) {
                for (const std::uint32_t threads : {32u, 96u, 1024u}) {
                    std::vector<std::atomic<int>> runs(blocks);
                    device.launch(blocks, threads, [&](const Block& block) {
                        if (block.threads() == threads) ++runs[block.index()];
                    });
                    CHECK(std::all_of(runs.begin(), runs.end(), [](int n) { return n == 1; }));
                }
            }
        }
    }
}

TEST_CASE("device: one thread per item, whatever the number of items", "[emulation][device]") {
    for (const ScheduleKind schedule : {ScheduleKind::free, ScheduleKind::shuffled}) {
        Device device({2, schedule, 0});
        for (const std::uint32_t items : {0u, 1u, 255u, 256u, 257u, 1000u}) {
            std::vector<std::atomic<int>> runs(items);
            device.launch_per_item(items, [&](std::uint32_t item) { ++runs.at(item); });
            CHECK(std::all_of(runs.begin(), runs.end(), [](int n) { return n == 1; }));
        }
    }
}

TEST_CASE("device: linear and reversed schedules run in that order", "[emulation][device]") {
    Device linear({0, ScheduleKind::linear, 0});
    Device reversed({0, ScheduleKind::reversed, 0});
    std::vector<std::uint32_t> expected = ascending(100);
    CHECK(order_of(linear, 100) == expected);
    std::reverse(expected.begin(), expected.end());
    CHECK(order_of(reversed, 100) == expected);
}

TEST_CASE("device: a shuffled schedule replays by its seed, launch by launch",
          "[emulation][device]") {
    Device first({0, ScheduleKind::shuffled, 42});
    Device again({0, ScheduleKind::shuffled, 42});
    Device other({0, ScheduleKind::shuffled, 43});
    const std::vector<std::uint32_t> launch1 = order_of(first, 100);
    const std::vector<std::uint32_t> launch2 = order_of(first, 100);
    CHECK(launch1 == order_of(again, 100));
    CHECK(launch2 == order_of(again, 100));
    CHECK(launch1 != launch2);
    CHECK(launch1 != order_of(other, 100));
    CHECK(launch1 != ascending(100));
    std::vector<std::uint32_t> sorted = launch1;
    std::sort(sorted.begin(), sorted.end());
    CHECK(sorted == ascending(100));
}

TEST_CASE("device: a shuffled schedule is the same on every machine", "[emulation][device]") {
    Device device({0, ScheduleKind::shuffled, 0});
    // Recorded once: std::mt19937_64 and the shuffle are both fixed by their definitions.
    CHECK(order_of(device, 8) == std::vector<std::uint32_t>{6, 4, 3, 7, 0, 5, 2, 1});
}

TEST_CASE("device: strided walks a square by its columns", "[emulation][device]") {
    Device device({0, ScheduleKind::strided, 0});
    CHECK(order_of(device, 7) == std::vector<std::uint32_t>{0, 3, 6, 1, 4, 2, 5});
    CHECK(order_of(device, 1) == std::vector<std::uint32_t>{0});
}

TEST_CASE("device: adversarial makes block 0, the middle and neighbours late, launch by launch",
          "[emulation][device]") {
    using Order = std::vector<std::uint32_t>;
    Device device({0, ScheduleKind::adversarial, 0});
    for (int round = 0; round < 2; ++round) {
        CHECK(order_of(device, 5) == Order{1, 2, 3, 4, 0});
        CHECK(order_of(device, 5) == Order{4, 0, 3, 1, 2});
        CHECK(order_of(device, 5) == Order{1, 3, 0, 2, 4});
        CHECK(order_of(device, 5) == Order{2, 3, 4, 0, 1});
    }
    for (const std::uint32_t few : {0u, 1u, 2u, 3u}) {
        for (int launch = 0; launch < 4; ++launch) {
            Order order = order_of(device, few);
            std::sort(order.begin(), order.end());
            CHECK(order == ascending(few));
        }
    }
}

TEST_CASE("schedule: a word names one exactly, and comes back", "[emulation][device]") {
    for (const std::string word :
         {"free", "linear", "reversed", "strided", "adversarial", "shuffle:0", "shuffle:17"}) {
        CHECK(to_string(parse_schedule(word)) == word);
    }
    CHECK(parse_schedule("shuffle:17").seed == 17);
    for (const std::string word :
         {"", "shuffle", "shuffle:", "shuffle:x", "shuffle:1 ", "serial"}) {
        CHECK_THROWS_WITH(parse_schedule(word),
                          Catch::Matchers::ContainsSubstring("shuffle:SEED") &&
                              Catch::Matchers::ContainsSubstring("'" + word + "'"));
    }
    const std::vector<Schedule> six = seeded_schedules(6);
    REQUIRE(six.size() == 6);
    CHECK(to_string(six[3]) == "adversarial");
    CHECK(to_string(six[5]) == "shuffle:2");
    CHECK(seeded_schedules(2).size() == 2);
}

TEST_CASE("device: every thread ends a phase before any begins the next", "[emulation][device]") {
    Device device({2, ScheduleKind::free, 0});
    for (const std::uint32_t threads : {32u, 64u, 1024u}) {
        std::atomic<int> late{0};
        std::atomic<int> idle{0};
        device.launch(20, threads, [&](const Block& block) {
            Shared<std::uint32_t> values("values");
            block.phase(
                [&](std::uint32_t thread) { values[thread] = block.global_thread(thread); });
            block.phase([&](std::uint32_t thread) {
                const std::uint32_t other = block.threads() - 1 - thread;
                if (values[other] != block.index() * threads + other) ++late;
            });
            std::uint32_t active = 0;
            block.phase(threads / 2, [&](std::uint32_t thread) {
                ++active;
                if (thread >= threads / 2) ++idle;
            });
            std::uint32_t zero = 0;
            block.phase_thread_zero([&] { ++zero; });
            if (active != threads / 2 || zero != 1) ++idle;
        });
        CHECK(late == 0);
        CHECK(idle == 0);
    }
}

TEST_CASE("device buffer: grows, keeps its memory when shrunk, and says how much it holds",
          "[emulation][device]") {
    DeviceBuffer<std::uint32_t> buffer;
    CHECK(buffer.size() == 0);
    CHECK(buffer.bytes() == 0);
    buffer.resize(10);
    CHECK(buffer.size() == 10);
    CHECK(buffer.bytes() == 40);
    for (std::uint32_t i = 0; i < 10; ++i) buffer[i] = i;
    const std::uint32_t* before = buffer.data();
    buffer.resize(4);
    CHECK(buffer.size() == 4);
    CHECK(buffer.view().size() == 4);
    CHECK(buffer.bytes() == 40);
    buffer.resize(10);
    CHECK(buffer.data() == before);
    CHECK(buffer[9] == 9);
    buffer.resize(1000);
    CHECK(buffer.span().size() == 1000);
    CHECK(buffer.bytes() == 4000);
    for (std::uint32_t i = 0; i < 1000; ++i) buffer[i] = i;
    CHECK(buffer.view().back() == 999);
}
