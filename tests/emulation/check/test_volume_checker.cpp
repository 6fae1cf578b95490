/// The checker on the emulator: every faulty kernel in phases is found and named.
#include <algorithm>
#include <atomic>
#include <functional>
#include <string>

#include "emulation/device/atomics.h"
#include "emulation/device/device.h"
#include "emulation/device/device_buffer.h"
#include "emulation/execution/launch_error.h"
#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "tests/catch.h"
#include "tests/emulation/simt/bad_addresses.h"
#include "tests/reference/meshes.h"

namespace {

using namespace scotty::emulation;
using Catch::Matchers::ContainsSubstring;
using scotty::emulation::simt::LaunchError;

// Lines that reports have to name.
constexpr int kSharedWrite = __LINE__ + 6;
constexpr int kSharedRead = __LINE__ + 7;

/// A thread reads its neighbour's value, in one phase or in the next.
void pass_on(const Block& block, std::uint32_t* out, bool in_two_phases) {
    Shared<std::uint32_t> values("values");
    const auto put = [&](std::uint32_t thread) { values[thread] = thread; };
    const auto take = [&](std::uint32_t thread) {
        out[block.global_thread(thread)] = values[(thread + 1) % block.threads()];
    };
    if (in_two_phases) {
        block.phase(put);
        block.phase(take);
    } else {
        block.phase([&](std::uint32_t thread) {
            put(thread);
            take(thread);
        });
    }
}

constexpr int kPlainAdd = __LINE__ + 2;
void count_plainly(const Block& block, std::uint32_t* counter) {
    block.phase_thread_zero([&] { *counter += 1; });
}

constexpr int kFollowed = __LINE__ + 5;
/// An index that nobody has written leads nowhere.
void follow(const Block& block, const std::uint32_t* index, std::uint32_t* to) {
    block.phase([&](std::uint32_t thread) {
        const std::uint64_t offset = index == nullptr ? 0 : index[0];
        if (block.index() == 1 && thread == 40) to[offset << 10] = 1;
    });
}

/// A running total over the threads is right only if they take turns.
void rank(const Block& block, std::uint32_t* out, bool in_order) {
    Shared<std::uint32_t, 1> total("total");
    block.phase_thread_zero([&] { total[0] = 0; });
    const auto take = [&](std::uint32_t thread) {
        out[block.global_thread(thread)] = total[0];
        total[0] += 1;
    };
    if (in_order) {
        block.phase_in_order(block.threads(), take);
    } else {
        block.phase(take);
    }
}

constexpr int kMemoryOnRegisters = __LINE__ + 3;
/// Declares a phase to be on registers that is not.
void add_on_registers(const Block& block, std::uint32_t* words) {
    block.phase_on_registers(32, [&](OwnThread thread) { words[thread] = words[thread] + 1; });
}

std::vector<DeviceOptions> every_order() {
    return {{2, ScheduleKind::free, 0},     {0, ScheduleKind::linear, 0},
            {0, ScheduleKind::reversed, 0}, {0, ScheduleKind::strided, 0},
            {0, ScheduleKind::shuffled, 3}, {0, ScheduleKind::adversarial, 0}};
}

/// A device with zeros in a buffer.
struct Memory {
    explicit Memory(const DeviceOptions& options, BufferUse use = BufferUse::any)
        : device(options), words(device, "the test's words", use) {
        words.resize(1024);
        words.fill(0);
    }
    void run(std::uint32_t blocks, std::uint32_t threads,
             const std::function<void(const Block&)>& kernel) {
        device.launch(blocks, threads, kernel);
    }
    std::string error_of(std::uint32_t blocks, std::uint32_t threads,
                         const std::function<void(const Block&)>& kernel) {
        try {
            run(blocks, threads, kernel);
        } catch (const LaunchError& error) {
            return error.what();
        }
        return "nothing";
    }
    Device device;
    DeviceBuffer<std::uint32_t> words;
};

std::string line(int number) {
    return "tests/emulation/check/test_volume_checker.cpp:" + std::to_string(number);
}

TEST_CASE("volume checker: two phases in one are a race, with both threads, lines and the object",
          "[simt][checker][volume]") {
    for (const DeviceOptions& options : every_order()) {
        Memory memory(options);
        const std::string what = memory.error_of(
            3, 64, [&](const Block& block) { pass_on(block, memory.words.data(), false); });
        CAPTURE(what);
        CHECK_THAT(what,
                   ContainsSubstring("(64 threads): data race on shared memory values, byte "));
        CHECK_THAT(what, ContainsSubstring(" writes it at " + line(kSharedWrite)));
        CHECK_THAT(what, ContainsSubstring(" reads it at " + line(kSharedRead)));
        CHECK_THAT(what, Catch::Matchers::Matches(
                             ".*block (\\d) .*thread \\d+ of block \\1 (writes|reads) it"
                             "(.|\n)*thread \\d+ of block \\1 (writes|reads) it(.|\n)*"));
        memory.run(3, 64, [&](const Block& block) { pass_on(block, memory.words.data(), true); });
    }
}

TEST_CASE("volume checker: a running total needs its turns", "[simt][checker][volume]") {
    for (const DeviceOptions& options : every_order()) {
        Memory memory(options);
        CHECK_THAT(
            memory.error_of(1, 32, [&](const Block& b) { rank(b, memory.words.data(), false); }),
            ContainsSubstring("data race on shared memory total, byte 0"));
        memory.run(2, 32, [&](const Block& b) { rank(b, memory.words.data(), true); });
        CHECK(memory.words[5] == 5);
        CHECK(memory.words[32] == 0);
    }
}

TEST_CASE("volume checker: a plain add on a counter races between blocks, and is named",
          "[simt][checker][volume]") {
    Memory memory({0, ScheduleKind::linear, 0});
    Watch::name_launch(scotty::reference::StageKind::intersect, {}, 12);
    const std::string what = memory.error_of(
        2, 32, [&](const Block& block) { count_plainly(block, memory.words.data() + 3); });
    Watch::name_launch(scotty::reference::StageKind::filter, {}, 0);
    CAPTURE(what);
    CHECK(memory.words[3] == 2);  // nothing went wrong, and it is still a finding
    CHECK_THAT(what,
               ContainsSubstring("kernel intersect of launch 12 intersect, block 1 (32 threads)"));
    CHECK_THAT(what, ContainsSubstring(
                         "data race on the test's words, byte 12 of 4096: thread 0 of block 0 "
                         "writes it at " +
                         line(kPlainAdd)));
    CHECK_THAT(what, ContainsSubstring("thread 0 of block 1 reads it at " + line(kPlainAdd)));
    memory.run(2, 32, [&](const Block& block) {
        block.phase([&](std::uint32_t) { atomic_add(memory.words[7], 1); });
    });
    CHECK(memory.words[7] == 64);
}

TEST_CASE("volume checker: a register of another thread is nobody else's",
          "[simt][checker][volume]") {
    Memory memory({0, ScheduleKind::linear, 0});
    const std::string what = memory.error_of(1, 32, [&](const Block& block) {
        PerThread<std::uint32_t> own;
        block.phase([&](std::uint32_t thread) { own[thread] = thread; });
        block.phase(31, [&](std::uint32_t thread) { memory.words[thread] = own[thread + 1]; });
    });
    CHECK_THAT(what, ContainsSubstring("thread 0 of block 0 touches a register of thread 1 at " +
                                       line(__LINE__ - 3)));
}

TEST_CASE("volume checker: a phase on registers touches no memory", "[simt][checker][volume]") {
    for (const DeviceOptions& options : every_order()) {
        Memory memory(options);
        std::uint32_t* const words = memory.words.data();
        const auto what_of = [&](const std::function<void(const Block&)>& kernel) {
            return memory.error_of(1, 32, kernel);
        };
        CHECK_THAT(
            what_of([&](const Block& block) { add_on_registers(block, words); }),
            ContainsSubstring("memory touched in a phase on registers, the test's words, byte ") &&
                ContainsSubstring("some thread of block 0 reads it at " +
                                  line(kMemoryOnRegisters)) &&
                ContainsSubstring("some thread of block 0 writes it at " +
                                  line(kMemoryOnRegisters)));
        CHECK_THAT(what_of([&](const Block& block) {
                       Shared<std::uint32_t> values("values");
                       block.phase_on_registers(32,
                                                [&](OwnThread thread) { values[thread] = thread; });
                   }),
                   ContainsSubstring(
                       "memory touched in a phase on registers, shared memory values, byte "));
        CHECK_THAT(what_of([&](const Block& block) {
                       PerThread<std::uint32_t> own;
                       block.phase_on_registers(
                           31, [&](OwnThread thread) { own[thread + 1] = thread; });
                   }),
                   ContainsSubstring("some thread of block 0 touches a register of thread "));
        // Each thread has its own register, and memory is watched again afterwards.
        CHECK(what_of([&](const Block& block) {
                  PerThread<std::uint32_t> own;
                  block.phase_on_registers(32, [&](OwnThread thread) { own[thread] = 7 * thread; });
                  block.phase([&](std::uint32_t thread) { words[thread] = own[thread]; });
              }) == "nothing");
        CHECK(words[31] == 7 * 31);
        CHECK_THAT(what_of([&](const Block& block) {
                       block.phase_on_registers(32, [&](OwnThread) {});
                       block.phase([&](std::uint32_t) { words[5] += 1; });
                   }),
                   ContainsSubstring("data race on the test's words, byte 20"));
    }
}

TEST_CASE("volume checker: memory that nobody has written, that is not there, or no more",
          "[simt][checker][volume]") {
    Memory memory({});
    DeviceBuffer<std::uint32_t> fresh(memory.device, "fresh memory");
    fresh.resize(10);
    std::uint32_t* const out = memory.words.data();
    constexpr std::uint32_t kRead = __LINE__ + 3;
    const auto read = [&](const std::uint32_t* from) {
        return memory.error_of(
            1, 32, [&](const Block& block) { block.phase_thread_zero([&] { out[0] = *from; }); });
    };
    const std::uint32_t* const at = fresh.data();
    CHECK_THAT(read(at + 2),
               ContainsSubstring("nobody has written fresh memory, byte 8 of 40: thread 0 of "
                                 "block 0 reads it at " +
                                 line(kRead)));
    fresh.fill(1);
    CHECK(read(at + 2) == "nothing");
    fresh.discard();
    CHECK_THAT(read(at + 2), ContainsSubstring("nobody has written fresh memory, byte 8 of 40"));
    CHECK_THAT(read(at + 10),
               ContainsSubstring("out of bounds, 0 bytes behind the end of fresh memory"));
    fresh.resize(1000);
    CHECK_THAT(read(at + 2), ContainsSubstring("freed memory, fresh memory, byte 8 of 40"));
    CHECK_THAT(
        memory.error_of(1, 32,
                        [&](const Block& block) {
                            Shared<std::uint32_t, 8> few("few");
                            block.phase(4, [&](std::uint32_t t) { few[t] = t; });
                            block.phase(5, [&](std::uint32_t t) { out[t] = few[t]; });
                        }),
        ContainsSubstring("nobody has written shared memory few, byte 16: thread 4 of block 0"));
    CHECK_THAT(
        memory.error_of(1, 32,
                        [&](const Block& block) {
                            Shared<std::uint32_t, 8> few("few");
                            block.phase([&](std::uint32_t t) { few[t] = t; });
                        }),
        ContainsSubstring("out of bounds, shared memory behind all of it, byte 0: thread 8"));
}

TEST_CASE("volume checker: memory that the process does not have is named with the line",
          "[simt][checker][volume]") {
    const scotty::simt::test::NobodyAnswersSignals as_outside_tests;
    const std::string where = "thread 40 reached memory that is not there at " + line(kFollowed);
    for (const DeviceOptions& options : every_order()) {
        Memory memory(options);
        std::uint32_t* const nowhere = scotty::simt::test::nowhere();
        const std::string what =
            memory.error_of(3, 64, [&](const Block& b) { follow(b, nullptr, nowhere); });
        CHECK_THAT(what, ContainsSubstring(", block 1 (64 threads): " + where));
        // The device is still usable.
        memory.run(3, 64, [&](const Block& b) { follow(b, nullptr, memory.words.data()); });
        CHECK(memory.words[0] == 1);
    }
    Memory memory({0, ScheduleKind::linear, 0});
    memory.words.discard();
    std::fill_n(memory.words.data(), 1024, 0xcdcdcdcd);
    std::uint32_t* const words = memory.words.data();
    const std::string what =
        memory.error_of(3, 64, [&](const Block& b) { follow(b, words, words); });
    CHECK_THAT(what,
               ContainsSubstring("nobody has written the test's words, byte 0 of 4096: thread 0 of "
                                 "block 0 reads it at " +
                                 line(kFollowed - 1)));
    CHECK_THAT(what, ContainsSubstring(where));
}

TEST_CASE("volume checker: a slot written twice names both writers", "[simt][checker][volume]") {
    Memory memory({0, ScheduleKind::linear, 0}, BufferUse::each_slot_once);
    constexpr std::uint32_t kFirst = __LINE__ + 2;
    const auto write_twice = [&](const Block& block) {
        block.phase_thread_zero([&] { memory.words[4] = 1; });
        block.phase(3, [&](std::uint32_t thread) {
            if (thread == 2) memory.words[4] = 1;
        });
    };
    memory.words.discard();
    const std::string what = memory.error_of(1, 32, write_twice);
    CHECK_THAT(what, ContainsSubstring(
                         "slot written twice, the test's words, byte 16 of 4096: thread 0 of "
                         "block 0 writes it at " +
                         line(kFirst) + ", thread 2 of block 0 writes it at " + line(kFirst + 2)));
}

TEST_CASE("volume checker: relaxed reads that meet atomics are no race, and are counted",
          "[simt][checker][volume]") {
    Memory memory({0, ScheduleKind::linear, 0});
    DeviceBuffer<float> minimum(memory.device, "minimum");
    minimum.resize(1);
    minimum.fill(1e9f);
    const auto met = [](int at) {
        std::uint64_t sum = 0;
        for (const auto& read : simt::relaxed_meetings()) {
            if (read.line == line(at)) sum += read.met;
        }
        return sum;
    };
    memory.run(4, 32, [&](const Block& block) {
        block.phase([&](std::uint32_t thread) {
            if (thread % 2 == 0) atomic_min_distance(minimum[0], static_cast<float>(thread));
            if (thread % 2 == 1) memory.words[thread] += load_relaxed(minimum[0]) < 9.0f ? 0 : 0;
        });
    });
    CHECK(met(__LINE__ - 3) >= 4 * 16 - 1);
    CHECK(met(__LINE__ - 6) == 0);  // the atomics are not counted
}

TEST_CASE("volume checker: the pipeline itself gives it nothing to say",
          "[simt][checker][volume]") {
    using namespace scotty::reference;
    Scene scene = test::soup(300, 0.3f, 1);
    const std::vector<Ray> rays = test::random_rays(700, 1.5f, 2);
    PipelineParameters p;
    p.rays_per_block = 64;
    p.hit_capacity = 1;
    for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
            p.early_out = early_out;
            p.hit_mode = mode;
            const WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
            std::vector<Hit> hits(rays.size());
            for (const DeviceOptions& options : every_order()) {
                Pipeline(scene, bvh, p, options).trace(rays, TraversalKind::closest, hits);
            }
            CHECK(hits.size() == rays.size());
        }
    }
}

}  // namespace
