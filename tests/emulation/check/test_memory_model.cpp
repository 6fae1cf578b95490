/// Compares the checker's shadow memory with a list of all accesses: random accesses of some blocks
/// whose threads pass barriers, until the first that nothing orders. The checker must report that
/// access, and nothing before it.
#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "emulation/check/memory_checker.h"
#include "emulation/execution/context.h"
#include "reference/base/error.h"
#include "tests/catch.h"

namespace {

using namespace scotty::emulation::simt;
using Catch::Matchers::ContainsSubstring;

/// The rules of memory_checker.h, with nothing forgotten.
struct Recorded {
    Access access;
    std::uint32_t word, block, thread, phase;
};
bool may_not_meet(Access one, Access other) {
    if (one == Access::write || other == Access::write) return true;
    return (one == Access::read && other == Access::atomic) ||
           (one == Access::atomic && other == Access::read);
}
bool races(const Recorded& one, const Recorded& other, bool shared) {
    if (one.word != other.word || !may_not_meet(one.access, other.access)) return false;
    if (one.block != other.block) return !shared;
    return one.phase == other.phase && one.thread != other.thread;
}

void tell(MemoryChecker& checker, Access access, const void* address, std::size_t bytes,
          const Context& running) {
    const auto* const place = reinterpret_cast<const void*>(&tell);
    switch (access) {
        case Access::read:
            return checker.on_access<Access::read>(address, bytes, place, running);
        case Access::write:
            return checker.on_access<Access::write>(address, bytes, place, running);
        case Access::relaxed_read:
            return checker.on_access<Access::relaxed_read>(address, bytes, place, running);
        case Access::atomic:
            return checker.on_access<Access::atomic>(address, bytes, place, running);
    }
}

/// A block between its accesses.
struct RunningBlock {
    explicit RunningBlock(std::uint32_t first_block, std::uint32_t index)
        : shared(std::make_unique<SharedMemory>()), shadow(SharedMemory::kBytes / 4) {
        context.first_block = first_block;
        context.block = index;
        context.shared = shared.get();
        context.shared_shadow = shadow.data();
    }
    std::unique_ptr<SharedMemory> shared;
    std::vector<SharedShadow> shadow;
    Context context{};
};

struct Run {
    std::size_t accesses = 0;
    bool raced = false;
};

/// One launch. `kinds` of accesses are few, so that long runs without a race occur too.
Run run_at_random(MemoryChecker& checker, std::uint32_t* words, std::mt19937& random,
                  const std::vector<Access>& kinds, bool shared) {
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::uint32_t kWords = 3;
    const std::uint32_t block_count = 1 + below(3);
    const std::uint32_t threads = 1 + below(3);
    const std::uint32_t first = checker.begin_launch("random", block_count);
    std::vector<RunningBlock> blocks;
    for (std::uint32_t i = 0; i < block_count; ++i) blocks.emplace_back(first, i);
    std::vector<void*> memory(block_count, words);
    std::vector<Recorded> all;
    if (shared) {
        for (std::uint32_t i = 0; i < block_count; ++i) {
            memory[i] = blocks[i].shared->object(&memory, "words", 4 * kWords, 4);
            // Device memory is written before the first phase that matters.
            for (std::uint32_t word = 0; word < kWords; ++word) {
                tell(checker, Access::write, static_cast<std::uint32_t*>(memory[i]) + word, 4,
                     blocks[i].context);
            }
            blocks[i].context.phase = 1;
        }
    }
    for (std::size_t step = 1; step <= 60; ++step) {
        Context& running = blocks[below(block_count)].context;
        running.phase += below(3) == 0 ? 1 : 0;
        running.thread = below(threads);
        const Recorded now{kinds[below(static_cast<std::uint32_t>(kinds.size()))], below(kWords),
                           running.block, running.thread, running.phase};
        tell(checker, now.access, static_cast<std::uint32_t*>(memory[now.block]) + now.word, 4,
             running);
        const bool expected = std::any_of(all.begin(), all.end(), [&](const Recorded& before) {
            return races(before, now, shared);
        });
        const std::vector<MemoryFinding> found = checker.take_findings();
        CAPTURE(step, now.block, now.thread, now.phase, now.word, static_cast<int>(now.access));
        REQUIRE(found.empty() != expected);
        if (expected) {
            CHECK(found.front().kind == MemoryFinding::Kind::race);
            return {step, true};
        }
        all.push_back(now);
    }
    return {60, false};
}

const std::vector<std::vector<Access>> kMixes = {
    {Access::read, Access::write},
    {Access::read, Access::read, Access::read, Access::read, Access::read, Access::write},
    {Access::atomic, Access::relaxed_read},
    {Access::atomic, Access::atomic, Access::relaxed_read, Access::read},
    {Access::atomic, Access::relaxed_read, Access::relaxed_read, Access::write},
    {Access::read, Access::relaxed_read, Access::relaxed_read, Access::read, Access::write},
    {Access::read, Access::write, Access::relaxed_read, Access::atomic}};

TEST_CASE("memory checker: says at the first access that races that it does, and nothing before",
          "[simt][checker]") {
    MemoryChecker checker;
    auto* const words = static_cast<std::uint32_t*>(checker.allocate_or_throw(64, "words"));
    checker.note_upload(words, 64);
    std::mt19937 random(7);
    for (const bool shared : {false, true}) {
        std::size_t raced = 0;
        std::size_t sound = 0;
        std::size_t late = 0;
        for (int run = 0; run < 4000; ++run) {
            const auto& kinds = kMixes[static_cast<std::size_t>(run) % kMixes.size()];
            const Run seen = run_at_random(checker, words, random, kinds, shared);
            (seen.raced ? raced : sound) += 1;
            late += seen.raced && seen.accesses > 10 ? 1 : 0;
        }
        CAPTURE(shared);
        // The runs were not idle.
        CHECK(raced > 1000);
        CHECK(sound > 300);
        CHECK(late > 100);
    }
}

TEST_CASE("memory checker: a thread is not told to have raced with itself", "[simt][checker]") {
    MemoryChecker checker;
    auto* const words = static_cast<std::uint32_t*>(checker.allocate_or_throw(64, "words"));
    checker.note_upload(words, 64);
    const std::uint32_t first = checker.begin_launch("kernel", 2);
    RunningBlock one(first, 0);
    RunningBlock other(first, 1);
    tell(checker, Access::read, words, 4, one.context);
    tell(checker, Access::read, words, 4, other.context);
    tell(checker, Access::write, words, 4, other.context);
    std::vector<MemoryFinding> found = checker.take_findings();
    REQUIRE(found.size() == 1);
    CHECK_THAT(to_text(found.front()),
               ContainsSubstring("a thread of another block reads it at ") &&
                   ContainsSubstring(", thread 0 of block 1 writes it at ") &&
                   !ContainsSubstring("no barrier"));
    one.context.first_block = checker.begin_launch("kernel", 1);
    one.context.thread = 1;
    tell(checker, Access::read, words + 1, 4, one.context);
    one.context.thread = 2;
    tell(checker, Access::read, words + 1, 4, one.context);
    one.context.thread = 1;
    tell(checker, Access::write, words + 1, 4, one.context);
    found = checker.take_findings();
    REQUIRE(found.size() == 1);
    CHECK_THAT(to_text(found.front()),
               ContainsSubstring("some thread of block 0 reads it at ") &&
                   ContainsSubstring(", thread 1 of block 0 writes it at ") &&
                   ContainsSubstring("no barrier is between"));
}

TEST_CASE("memory checker: nothing is left of an earlier checker's memory", "[simt][checker]") {
    const auto nothing_there = [](MemoryChecker& checker, std::uint32_t first) {
        RunningBlock block(first, 0);
        const std::byte* const begin =
            reinterpret_cast<const std::byte*>(&checker) - checker.offset_of(&checker);
        tell(checker, Access::read, begin + 4096, 4, block.context);
        const std::vector<MemoryFinding> found = checker.take_findings();
        return found.size() == 1 && found.front().kind == MemoryFinding::Kind::outside;
    };
    for (int round = 0; round < 3; ++round) {
        MemoryChecker checker;
        CHECK(nothing_there(checker, checker.begin_launch("before", 1)));
        auto* const words = static_cast<std::uint32_t*>(checker.allocate_or_throw(64, "words"));
        CHECK_FALSE(checker.last_writer(words).has_value());
        CHECK_FALSE(checker.last_writer(words + 1).has_value());
        RunningBlock block(checker.begin_launch("kernel", 1), 0);
        tell(checker, Access::read, words, 4, block.context);
        std::vector<MemoryFinding> found = checker.take_findings();
        REQUIRE(found.size() == 1);
        CHECK(found.front().kind == MemoryFinding::Kind::unwritten);
        tell(checker, Access::write, words, 4, block.context);
        tell(checker, Access::write, words + 1, 4, block.context);
        block.context.phase = 1;
        tell(checker, Access::atomic, words + 1, 4, block.context);
        CHECK(checker.take_findings().empty());
        REQUIRE(checker.last_writer(words).has_value());
        CHECK(checker.last_writer(words)->kernel == "kernel");
        CHECK(checker.last_writer(words)->in_last_launch);
    }
}

TEST_CASE("memory checker: who wrote last, plainly or atomically, and in which launch",
          "[simt][checker]") {
    MemoryChecker checker;
    auto* const words = static_cast<std::uint32_t*>(checker.allocate_or_throw(64, "words"));
    checker.note_upload(words, 64);
    CHECK_FALSE(checker.last_writer(words).has_value());
    const auto run = [&](const char* kernel, Access access, std::uint32_t block) {
        RunningBlock running(checker.begin_launch(kernel, 8), block);
        running.context.thread = 5;
        tell(checker, access, words, 4, running.context);
    };
    run("plain", Access::write, 3);
    run("adds", Access::atomic, 6);
    run("looks", Access::read, 2);
    auto writer = checker.last_writer(words);
    REQUIRE(writer.has_value());
    CHECK(writer->kernel == "adds");
    CHECK(writer->atomically);
    CHECK(writer->block == 6);
    CHECK(writer->thread == 5);
    CHECK_FALSE(writer->in_last_launch);
    run("plain again", Access::write, 7);
    writer = checker.last_writer(words);
    REQUIRE(writer.has_value());
    CHECK(writer->kernel == "plain again");
    CHECK_FALSE(writer->atomically);
    CHECK(writer->block == 7);
    CHECK(writer->in_last_launch);
    checker.note_upload(words, 4);
    CHECK_FALSE(checker.last_writer(words).has_value());
    CHECK(checker.take_findings().empty());
}

TEST_CASE("memory checker: more blocks than it can tell apart are refused", "[simt][checker]") {
    {
        MemoryChecker checker;
        checker.begin_launch("kernel", 4'000'000'000u);
        CHECK_THROWS_WITH(checker.begin_launch("kernel", 400'000'000u),
                          ContainsSubstring("--check: more than two billion blocks") &&
                              ContainsSubstring("--size"));
    }
    MemoryChecker next;  // it numbers from the start again
    CHECK(next.begin_launch("kernel", 4'000'000'000u) == 1);
}

}  // namespace
