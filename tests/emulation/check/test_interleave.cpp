/// Blocks switched in their middle: faults of only some orders are found, shrunk, saved, replayed.
#include <filesystem>
#include <fstream>

#include "emulation/simt/cuda/cuda_runtime.h"
#include "emulation/simt/interleave/replayer.h"
#include "tests/emulation/simt/executor_tools.h"

namespace scotty::gpu::simt {
namespace {

/// A lost update: reads, and then writes the value plus one.
SCOTTY_KERNEL(add_slowly)(std::uint32_t* counter, bool atomically) {
    if (thread_index() == 0) {
        if (atomically) {
            atomic_add(counter, 1);
        } else {
            const std::uint32_t before = *counter;
            *counter = before + 1;
        }
    }
    SCOTTY_RETURN;
}

/// Each block has words of its own, and all share one.
SCOTTY_KERNEL(mostly_own)(std::uint32_t* words, int rounds) {
    std::uint32_t* own = words + 64 * (1 + block_index());
    for (int round = 0; round < rounds; ++round) own[thread_index()] += 1;
    SCOTTY_SYNC();
    if (thread_index() == 0) atomic_add(words, own[0]);
    SCOTTY_RETURN;
}

/// It goes wrong only if two blocks are stopped: block 0 between its two looks, and block 1 in its
/// middle.
SCOTTY_KERNEL(two_flags)(std::uint32_t* words) {
    if (thread_index() == 0) {
        if (block_index() == 0) {
            const std::uint32_t first = atomic_add(words, 0);
            const std::uint32_t second = atomic_add(words + 1, 0);
            if (first == 0 && second == 1) words[2] = 1;
        } else {
            atomic_add(words, 1);
            atomic_add(words + 1, 1);
            atomic_add(words + 1, 1);
        }
    }
    SCOTTY_RETURN;
}

/// Block 0 waits for the value that the last block publishes.
SCOTTY_KERNEL(wait_for_last)(std::uint64_t* words, bool published) {
    if (thread_index() == 0) {
        if (block_index() + 1 == grid_size()) {
            if (published) store_relaxed(words, 5);
        } else {
            while (load_relaxed(words) == 0) {
            }
            words[1 + block_index()] = load_relaxed(words);
        }
    }
    SCOTTY_RETURN;
}

}  // namespace
}  // namespace scotty::gpu::simt

namespace {

using namespace scotty::gpu::simt;
using namespace scotty::simt::test;
using namespace scotty::emulation::simt;
using Catch::Matchers::ContainsSubstring;

constexpr std::size_t kWords = 1024;

/// Zeros before each launch; the outcome is all words.
struct Explored {
    Explored() : executor(SimtOptions{}), here((executor.check_memory(), executor)) {
        cudaMalloc(reinterpret_cast<void**>(&memory), 4 * kWords);
    }
    ~Explored() { cudaFree(memory); }
    Explored(const Explored&) = delete;
    Explored& operator=(const Explored&) = delete;

    template <class Kernel, class... Arguments>
    InterleavedRun run(const char* name, std::uint32_t blocks, Kernel kernel,
                       Arguments... arguments) {
        return [=, this](Interleaver& interleaver) {
            cudaMemset(memory, 0, 4 * kWords);
            executor.interleave(&interleaver);
            executor.launch(name, blocks, 32, kernel, arguments...);
            return std::string(reinterpret_cast<const char*>(memory), 4 * kWords);
        };
    }
    const MemoryChecker& checker() const { return *executor.checker(); }

    Executor executor;
    CurrentDevice here;
    std::uint32_t* memory = nullptr;
};

TEST_CASE("interleaving: a lost update is found, shrunk to one switch, saved, and replayed",
          "[simt][interleave]") {
    Explored device;
    const auto run = device.run("add_slowly", 3, add_slowly, device.memory, false);
    // One block after the other loses nothing, whichever is first.
    CHECK(replay(device.checker(), run, {"add_slowly", 3, 32, {}})[0] == 3);

    const Exploration found = explore(device.checker(), run);
    CHECK(found.expected[0] == 3);
    REQUIRE(found.failing.has_value());
    CHECK(found.found[0] < 3);
    REQUIRE(found.failing->switches.size() == 1);
    const Switch change = found.failing->switches[0];
    CHECK(change.access == 2);  // between its read and its write

    const auto file = std::filesystem::temp_directory_path() / "scotty_lost_update.interleaving";
    write_interleaving(file, *found.failing);
    const Interleaving read = read_interleaving(file);
    std::filesystem::remove(file);
    CHECK(read == *found.failing);
    CHECK(replay(device.checker(), run, read) == found.found);
    CHECK(replay(device.checker(), run, read) == found.found);
    CHECK_THAT(to_text(read), ContainsSubstring("stands before access 2, block"));
}

TEST_CASE("interleaving: an atomic add loses nothing in any order of two, three and four blocks",
          "[simt][interleave]") {
    for (const auto& [blocks, orders] : {std::pair{2u, 2u}, {3u, 6u}, {4u, 24u}}) {
        Explored device;
        const Exploration all = explore(
            device.checker(), device.run("add_slowly", blocks, add_slowly, device.memory, true));
        CHECK_FALSE(all.failing.has_value());
        CHECK(all.complete);
        CHECK(all.words == 1);
        CHECK(all.schedules == orders);  // each order of the dependent accesses runs once
    }
}

TEST_CASE("interleaving: what no other block touches is no place to switch", "[simt][interleave]") {
    Explored device;
    const Exploration all =
        explore(device.checker(), device.run("mostly_own", 3, mostly_own, device.memory, 20));
    CHECK(all.complete);
    CHECK(all.words == 1);
    CHECK(all.schedules == 6);
    CHECK_FALSE(all.failing.has_value());
}

TEST_CASE("interleaving: two switches are found where one does not do, also within a bound",
          "[simt][interleave]") {
    for (const std::optional<std::uint32_t> bound : {std::optional<std::uint32_t>{}, {2u}}) {
        Explored device;
        const auto run = device.run("two_flags", 2, two_flags, device.memory);
        const Exploration found = explore(device.checker(), run, {bound, 1000});
        REQUIRE(found.failing.has_value());
        CHECK(found.failing->switches.size() == 2);
    }
    Explored device;
    const auto run = device.run("two_flags", 2, two_flags, device.memory);
    const Exploration one = explore(device.checker(), run, {1u, 1000});
    CHECK(one.complete);
    CHECK_FALSE(one.failing.has_value());
}

TEST_CASE(
    "interleaving: a block that waits lets others go on, and one that waits for ever is named",
    "[simt][interleave]") {
    Explored device;
    auto* words = reinterpret_cast<std::uint64_t*>(device.memory);
    const Exploration all =
        explore(device.checker(), device.run("wait_for_last", 3, wait_for_last, words, true));
    CHECK(all.complete);
    CHECK_FALSE(all.failing.has_value());
    CHECK(all.expected[8] == 5);
    const auto never = device.run("wait_for_last", 2, wait_for_last, words, false);
    CHECK_THAT(replay(device.checker(), never, {"wait_for_last", 2, 32, {}}),
               ContainsSubstring("kernel wait_for_last, block 0") &&
                   ContainsSubstring("wait for each other"));
}

TEST_CASE("interleaving: more schedules than allowed is said, not passed over",
          "[simt][interleave]") {
    Explored device;
    const Exploration some = explore(
        device.checker(), device.run("add_slowly", 4, add_slowly, device.memory, true), {{}, 5});
    CHECK_FALSE(some.complete);
    CHECK(some.schedules == 5);
}

TEST_CASE("interleaving: a file that is none, or of another launch, is refused with its line",
          "[simt][interleave]") {
    const auto file = std::filesystem::temp_directory_path() / "scotty_bad.interleaving";
    const auto refused = [&](const std::string& text, const std::string& why) {
        std::ofstream(file) << text;
        CHECK_THROWS_WITH(read_interleaving(file), ContainsSubstring(why));
    };
    const std::string title = "# scotty interleaving, version 1\n";
    refused("kernel a\n", "line 1: expected '# scotty");
    refused(title + "kernel a\nblocks many\n", "line 3: expected kernel NAME");
    refused(title + "kernel a\nblocks 2\nthreads 32\nswitch 0 1 2\n", "line 5");
    refused(title + "kernel a\nblocks 2\n", "names no kernel, blocks or threads");
    std::filesystem::remove(file);
    CHECK_THROWS_WITH(read_interleaving(file), ContainsSubstring("cannot be read"));
    CHECK_THROWS_WITH(write_interleaving("/proc/no/a", {"a", 1, 32, {}}),
                      ContainsSubstring("cannot be written"));
    Explored device;
    const auto run = device.run("add_slowly", 3, add_slowly, device.memory, false);
    CHECK_THROWS_WITH(replay(device.checker(), run, {"add_slowly", 2, 32, {}}),
                      ContainsSubstring("expected a launch of kernel add_slowly in 2 blocks"));
}

}  // namespace
