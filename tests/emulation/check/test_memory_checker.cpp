/// What the checker of memory accesses finds, and what it must not report.
#include <algorithm>
#include <cstring>

#include "emulation/check/deliberate.h"
#include "emulation/check/source_line.h"
#include "emulation/simt/cuda/cuda_runtime.h"
#include "tests/catch.h"
#include "tests/emulation/simt/bad_addresses.h"
#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

struct Words {
    std::uint32_t at[256];
};

// Lines that reports have to name.
constexpr std::uint32_t kSharedWrite = __LINE__ + 6;
constexpr std::uint32_t kSharedRead = __LINE__ + 8;

/// A thread reads what its neighbour has written.
SCOTTY_KERNEL(pass_on)(std::uint32_t* out, bool with_barrier) {
    SCOTTY_SHARED(Words, shared);
    shared.at[thread_index()] = thread_index();
    if (with_barrier) SCOTTY_SYNC();
    out[block_index() * block_size() + thread_index()] =
        shared.at[(thread_index() + 1) % block_size()];
    SCOTTY_RETURN;
}

constexpr std::uint32_t kPlainAdd = __LINE__ + 3;
SCOTTY_KERNEL(count_threads)(std::uint32_t* counter, bool atomic) {
    if (!atomic) {
        *counter += 1;
    } else {
        atomic_add(counter, 1);
    }
    SCOTTY_RETURN;
}

/// The early-out's pattern: some threads lower the minimum while others read it.
SCOTTY_KERNEL(lower_and_look)(float* minimum, float* out, bool relaxed) {
    const std::uint32_t thread = block_index() * block_size() + thread_index();
    if (thread % 2 == 0) {
        atomic_min_distance(minimum, static_cast<float>(thread + 1));
    } else {
        out[thread] = relaxed ? load_relaxed(minimum) : *minimum;
    }
    SCOTTY_RETURN;
}

SCOTTY_KERNEL(read_word)(const std::uint32_t* from, std::uint32_t index, std::uint32_t* out) {
    if (thread_index() == 0) out[0] = from[index];
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(write_word)(std::uint32_t* to, std::uint32_t index) {
    if (thread_index() == 3) to[index] = 1;
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(write_slot_in_two_phases)(std::uint32_t* to) {
    if (thread_index() == 3) to[2] = 1;
    SCOTTY_SYNC();
    if (thread_index() == 5) to[2] = 2;
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(read_unwritten_shared)(std::uint32_t* out) {
    SCOTTY_SHARED(Words, shared);
    if (thread_index() == 0) shared.at[0] = 1;
    SCOTTY_SYNC();
    if (thread_index() == 1) out[0] = shared.at[0] + shared.at[7];
}
SCOTTY_KERNEL(write_behind_shared)(std::uint32_t index) {
    SCOTTY_SHARED(Words, shared);
    if (thread_index() == 5) (&shared.at[0])[index] = 1;
    SCOTTY_RETURN;
}
/// Between two objects: `index` counts words from the first one's begin.
SCOTTY_KERNEL(step_beyond_shared)(std::uint32_t index, bool reads, std::uint32_t* out) {
    SCOTTY_SHARED(Words, first);
    SCOTTY_SHARED(Words, second);
    first.at[thread_index()] = 0;
    second.at[thread_index()] = 1;
    SCOTTY_SYNC();
    if (thread_index() == 5 && reads) *out = (&first.at[0])[index];
    if (thread_index() == 5 && !reads) (&first.at[0])[index] = 7;
    SCOTTY_RETURN;
}
/// Blocks use the same piece of memory one after the other, which is not sharing.
SCOTTY_KERNEL(own_shared)(std::uint32_t* out) {
    SCOTTY_SHARED(Words, shared);
    shared.at[thread_index()] = block_index();
    SCOTTY_SYNC();
    if (thread_index() == 0) out[block_index()] = shared.at[block_size() - 1];
}
/// Lanes of a warp run together, but without a barrier that orders nothing.
SCOTTY_KERNEL(ballot_is_no_barrier)(std::uint32_t* out) {
    SCOTTY_SHARED(Words, shared);
    shared.at[thread_index()] = 1;
    const std::uint32_t lanes = SCOTTY_AWAIT(warp_ballot(true));
    out[thread_index()] = lanes + shared.at[(thread_index() + 1) % block_size()];
}

constexpr std::uint32_t kFollowed = __LINE__ + 6;
/// An index that nobody has written leads nowhere.
SCOTTY_KERNEL(follow)(const std::uint32_t* indices, std::uint32_t* to) {
    SCOTTY_SYNC();
    if (block_index() == 1 && thread_index() == 40) {
        const std::uint64_t index = indices == nullptr ? 0 : indices[5];
        to[index << 10] = 1;
    }
    SCOTTY_RETURN;
}
SCOTTY_KERNEL(look_nowhere)(const float* from, float* out) {
    if (thread_index() == 7) *out = load_relaxed(from);
    SCOTTY_RETURN;
}

/// Copies of all sizes, by all means: thread 0 reads `words` words from one place and writes them
/// to another. The means have to be heard like single words.
enum class Means : std::uint8_t { record, memcpy_fixed, memcpy_any, memmove_any, copy, fill };
template <std::size_t words>
struct Record {
    std::uint32_t at[words];
};
template <std::size_t words>
void copy_by(Means means, const std::uint32_t* from, std::uint32_t* to, std::size_t bytes) {
    switch (means) {
        case Means::record:
            *reinterpret_cast<Record<words>*>(to) = *reinterpret_cast<const Record<words>*>(from);
            break;
        case Means::memcpy_fixed:
            std::memcpy(to, from, words * 4);
            break;
        case Means::memcpy_any:
            std::memcpy(to, from, bytes);
            break;
        case Means::memmove_any:
            std::memmove(to, from, bytes);
            break;
        case Means::copy:
            std::copy(from, from + bytes / 4, to);
            break;
        case Means::fill:
            std::memset(to, 0, bytes);
            break;
    }
}
SCOTTY_KERNEL(copy_words)
(Means means, std::uint32_t words, const std::uint32_t* from, std::uint32_t* to) {
    if (thread_index() == 0) {
        const std::size_t bytes = words * sizeof(std::uint32_t);
        if (words == 3) copy_by<3>(means, from, to, bytes);
        if (words == 5) copy_by<5>(means, from, to, bytes);
        if (words == 12) copy_by<12>(means, from, to, bytes);
        if (words == 64) copy_by<64>(means, from, to, bytes);
    }
    SCOTTY_RETURN;
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;
using scotty::emulation::simt::CurrentDevice;

/// An executor that checks, with device memory of `words` zeros.
struct Checked {
    explicit Checked(const SimtOptions& options, std::size_t words = 1024)
        : executor(options), here((executor.check_memory(), executor)) {
        cudaMalloc(reinterpret_cast<void**>(&memory), 4 * words);
        cudaMemset(memory, 0, 4 * words);
        label_memory(memory, "the test's memory");
    }
    ~Checked() { cudaFree(memory); }
    Checked(const Checked&) = delete;
    Checked& operator=(const Checked&) = delete;

    Executor executor;
    CurrentDevice here;
    std::uint32_t* memory = nullptr;
};

std::string said(const std::function<void()>& launch) { return error_of(launch).what(); }

auto says(const std::string& text) {
    return Catch::Matchers::Matches("(.|\n)*" + text + "(.|\n)*");
}
std::string line(std::uint32_t number) {
    return "tests/emulation/check/test_memory_checker\\.cpp:" + std::to_string(number);
}

}  // namespace

TEST_CASE("checker: a missing barrier is named with its kernel, both lines and both threads",
          "[simt][checker]") {
    for (const SimtOptions& options : every_order()) {
        Checked device(options);
        const std::string what =
            said([&] { device.executor.launch("pass_on", 2, 64, pass_on, device.memory, false); });
        CAPTURE(what);
        CHECK_THAT(what, says("kernel pass_on, block [01] \\(64 threads\\): data race on shared "
                              "memory shared, byte \\d+"));
        CHECK_THAT(what, says(line(kSharedWrite)));
        CHECK_THAT(what, says(line(kSharedRead)));
        CHECK_THAT(what, says("thread \\d+ of block [01] writes it"));
        CHECK_THAT(what, says("thread \\d+ of block [01] reads it"));
        CHECK_THAT(what, says("no barrier is between"));
    }
}

TEST_CASE("checker: with the barrier there is nothing to say", "[simt][checker]") {
    for (const SimtOptions& options : every_order()) {
        Checked device(options);
        for (int launch = 0; launch < 3; ++launch) {
            device.executor.launch("pass_on", 4, 64, pass_on, device.memory, true);
            device.executor.launch("own_shared", 16, 64, own_shared, device.memory);
        }
    }
}

TEST_CASE("checker: a plain add on a counter races though nothing was lost", "[simt][checker]") {
    for (const std::uint32_t blocks : {1u, 2u}) {
        Checked device({0, ScheduleKind::linear, 0});
        const std::string what = said([&] {
            device.executor.launch("count_threads", blocks, 32, count_threads, device.memory,
                                   false);
        });
        CAPTURE(what);
        CHECK(*device.memory == 32 * blocks);
        CHECK_THAT(what, says("data race on the test's memory, byte 0 of 4096"));
        CHECK_THAT(what, says(line(kPlainAdd)));
    }
    Checked device({});
    device.executor.launch("count_threads", 64, 32, count_threads, device.memory, true);
    CHECK(*device.memory == 64 * 32);
}

TEST_CASE("checker: a read that others may overtake has to say so", "[simt][checker]") {
    Checked device({});
    auto* minimum = reinterpret_cast<float*>(device.memory);
    *minimum = 1e9f;
    device.executor.launch("lower_and_look", 4, 64, lower_and_look, minimum, minimum + 1, true);
    *minimum = 1e9f;
    CHECK_THAT(said([&] {
                   device.executor.launch("lower_and_look", 4, 64, lower_and_look, minimum,
                                          minimum + 1, false);
               }),
               says("data race on the test's memory, byte 0 .*changes it atomically"));
}

TEST_CASE("checker: memory that nobody has written, that is not there, or no more",
          "[simt][checker]") {
    Checked device({});
    std::uint32_t* fresh = nullptr;
    cudaMalloc(reinterpret_cast<void**>(&fresh), 40);
    label_memory(fresh, "fresh memory");
    std::uint32_t* const out = device.memory;
    const auto read = [&](std::uint32_t index) {
        return said(
            [&] { device.executor.launch("read_word", 1, 32, read_word, fresh, index, out); });
    };
    CHECK_THAT(read(2), says("nobody has written fresh memory, byte 8 of 40: thread 0 of block 0 "
                             "reads it at tests/emulation/check"));
    device.executor.launch("write_word", 1, 32, write_word, fresh, 2);
    device.executor.launch("read_word", 1, 32, read_word, fresh, 2, out);
    CHECK(*out == 1);
    CHECK_THAT(read(10),
               says("out of bounds, 0 bytes behind the end of fresh memory \\(40 bytes\\)"));
    CHECK_THAT(said([&] { device.executor.launch("write_word", 1, 32, write_word, fresh, 1000); }),
               says("out of bounds, \\d+ bytes behind the end of fresh memory .40 bytes.: thread 3 "
                    "of block 0 writes it"));
    cudaFree(fresh);
    CHECK_THAT(read(2), says("freed memory, fresh memory, byte 8 of 40"));
    CHECK_THAT(said([&] {
                   device.executor.launch("read_unwritten_shared", 1, 32, read_unwritten_shared,
                                          out);
               }),
               says("nobody has written shared memory shared, byte 28: thread 1 of block 0"));
    device.executor.launch("write_behind_shared", 1, 32, write_behind_shared, 255u);
    CHECK_THAT(
        said([&] {
            device.executor.launch("write_behind_shared", 1, 32, write_behind_shared, 300u);
        }),
        says(
            "out of bounds, shared memory behind all of it, byte 176: thread 5 of block 0 writes"));
}

TEST_CASE("checker: a step beyond a shared object lands in no other", "[simt][checker]") {
    Checked device({});
    const auto step = [&](std::uint32_t index, bool reads) {
        device.executor.launch("step_beyond_shared", 1, 32, step_beyond_shared, index, reads,
                               device.memory);
    };
    step(30, true);
    step(30, false);
    CHECK_THAT(said([&] { step(256, true); }),
               says("out of bounds, shared memory 0 bytes behind the end of first .1024 bytes.: "
                    "thread 5 of block \\d reads it at tests/emulation/check"));
    CHECK_THAT(said([&] { step(257, false); }),
               says("out of bounds, shared memory 4 bytes behind the end of first .1024 bytes.: "
                    "thread 5 of block \\d writes it at tests/emulation/check"));
}

TEST_CASE("checker: copies of any size, by any means, are heard as a whole", "[simt][checker]") {
    for (const Means means : {Means::record, Means::memcpy_fixed, Means::memcpy_any,
                              Means::memmove_any, Means::copy, Means::fill}) {
        for (const std::uint32_t words : {3u, 5u, 12u, 64u}) {
            CAPTURE(static_cast<int>(means), words);
            Checked device({});
            std::uint32_t* fresh = nullptr;
            cudaMalloc(reinterpret_cast<void**>(&fresh), 4 * words);
            label_memory(fresh, "fresh memory");
            const auto copy = [&](const std::uint32_t* from, std::uint32_t* to) {
                return said([&] {
                    device.executor.launch("copy_words", 1, 32, copy_words, means, words, from, to);
                });
            };
            if (means != Means::fill) {
                CHECK_THAT(copy(fresh, device.memory), says("nobody has written fresh memory"));
            }
            CHECK_THAT(copy(device.memory, fresh + 1),
                       says("out of bounds, 0 bytes behind the end of fresh memory"));
            device.executor.launch("copy_words", 1, 32, copy_words, means, words, device.memory,
                                   fresh);
            device.executor.launch("read_word", 1, 32, read_word, fresh, words - 1, device.memory);
            cudaFree(fresh);
        }
    }
}

TEST_CASE("checker: memory that the process does not have is named with the line that reached it",
          "[simt][checker]") {
    const NobodyAnswersSignals as_outside_tests;
    for (const SimtOptions& options : every_order()) {
        Checked device(options);
        const std::uint32_t* const none = nullptr;
        const std::string what =
            said([&] { device.executor.launch("follow", 3, 64, follow, none, nowhere()); });
        CAPTURE(what);
        CHECK_THAT(what, says("kernel follow, block 1 .64 threads.: thread 40 reached memory that "
                              "is not there at " +
                              line(kFollowed)));
        device.executor.launch("follow", 3, 64, follow, none, device.memory);
        CHECK(device.memory[0] == 1);
    }
}

TEST_CASE("checker: what has led a thread to memory that is not there is told first",
          "[simt][checker]") {
    const NobodyAnswersSignals as_outside_tests;
    Checked device({});
    discard_slots(device.memory, 400);
    for (std::uint32_t i = 0; i < 100; ++i) device.memory[i] = 0xcdcdcdcd;
    CHECK_THAT(said([&] {
                   device.executor.launch("follow", 3, 64, follow, device.memory, device.memory);
               }),
               says("nobody has written the test's memory, byte 20 of 4096: thread 40 of block 1 "
                    "reads it at " +
                    line(kFollowed - 1) +
                    "; then kernel follow, block 1 .64 threads.: thread 40 reached memory that is "
                    "not there at " +
                    line(kFollowed)));
}

TEST_CASE("checker: a relaxed read of memory that is not there leaves no mark on later reads",
          "[simt][checker]") {
    const NobodyAnswersSignals as_outside_tests;
    Checked device({0, ScheduleKind::linear, 0});
    auto* const minimum = reinterpret_cast<float*>(device.memory);
    const auto* const from = reinterpret_cast<const float*>(nowhere());
    CHECK_THAT(
        said([&] { device.executor.launch("look_nowhere", 1, 32, look_nowhere, from, minimum); }),
        says("thread 7 reached memory that is not there at"));
    CHECK_THAT(said([&] {
                   device.executor.launch("lower_and_look", 2, 64, lower_and_look, minimum,
                                          minimum + 8, false);
               }),
               says("data race on the test's memory"));
    CHECK_FALSE(scotty::emulation::simt::deliberate_read);
}

TEST_CASE("checker: a slot written twice names both writers, one never written its reader",
          "[simt][checker]") {
    Checked device({});
    discard_slots(device.memory, 400);
    const std::string what = said([&] {
        device.executor.launch("write_slot_in_two_phases", 1, 32, write_slot_in_two_phases,
                               device.memory);
    });
    CHECK_THAT(what,
               says("slot written twice, the test's memory, byte 8 of 4096: thread 3 of block "
                    "0 writes it at .*, thread 5 of block 0 writes it at"));
    discard_slots(device.memory, 400);  // another launch: the slots are new
    device.executor.launch("write_word", 1, 32, write_word, device.memory, 2);
    CHECK_THAT(said([&] {
                   device.executor.launch("read_word", 1, 32, read_word, device.memory, 3,
                                          device.memory + 200);
               }),
               says("nobody has written the test's memory, byte 12"));
}

TEST_CASE("checker: warp collectives order no memory", "[simt][checker]") {
    Checked device({});
    CHECK_THAT(said([&] {
                   device.executor.launch("ballot_is_no_barrier", 1, 32, ballot_is_no_barrier,
                                          device.memory);
               }),
               says("data race on shared memory"));
}

TEST_CASE("checker: who wrote a value that the host has copied", "[simt][checker]") {
    Checked device({});
    device.executor.launch("write_word", 1, 32, write_word, device.memory + 5, 0);
    std::uint32_t host[8] = {};
    cudaMemcpy(host, device.memory, sizeof host, cudaMemcpyDeviceToHost);
    CHECK_FALSE(device.executor.checker()->last_writer(&host[4]).has_value());
    const auto writer = device.executor.checker()->last_writer(&host[5]);
    REQUIRE(writer.has_value());
    CHECK(writer->kernel == "write_word");
    CHECK(writer->thread == 3);
    CHECK(writer->in_last_launch);
    CHECK_THAT(scotty::emulation::simt::source_line(writer->place),
               says("tests/emulation/check/test_memory_checker\\.cpp:\\d+"));
    CHECK_FALSE(device.executor.checker()->last_writer(host + 100).has_value());
}
