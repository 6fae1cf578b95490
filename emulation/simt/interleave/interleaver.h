/// Runs the blocks of a launch in turns that change in their middle; each block is a fiber.
///
/// The instrumented kernel announces every access to device memory (instrumentation.cpp)
/// before it happens. There a block may pause and another goes on; a Chooser says which.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "emulation/check/memory_checker.h"
#include "emulation/simt/block_runner.h"
#include "emulation/simt/interleave/fiber.h"

namespace scotty::emulation::simt {

/// Four-byte words of device memory, [first, last], and whether they are changed. A relaxed read
/// counts as a read, an atomic as a write, whether or not it changes the word.
struct Touch {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    bool writes = false;

    bool operator==(const Touch&) const = default;
};
inline bool dependent(const Touch& a, const Touch& b) {
    return a.first <= b.last && b.first <= a.last && (a.writes || b.writes);
}

/// The state of a launch's paused blocks.
struct BlockState {
    bool begun = false;
    bool over = false;
    /// It has read a word that is unchanged since it last read it: it waits for others.
    bool waits = false;
    std::uint32_t accesses = 0;  ///< begun so far, including the one that it pauses before
    Touch next;                  ///< the access that it pauses before

    bool can_run() const { return !over && !waits; }
};

class Chooser {
 public:
    Chooser() = default;
    Chooser(const Chooser&) = delete;
    Chooser& operator=(const Chooser&) = delete;
    virtual ~Chooser() = default;

    /// Called before anything runs.
    virtual void begin(const Launch& launch) = 0;
    /// Whether all blocks run to their first stop before the first choice.
    virtual bool begins_all() const = 0;
    /// Whether the running block pauses before this, its `access`-th access.
    virtual bool stops(std::uint32_t block, std::uint32_t access, const Touch& touch) = 0;
    /// Which block goes on; it must be able to run. `current` ran last. At least one block can.
    virtual std::uint32_t choose(const std::vector<BlockState>& blocks, std::uint32_t current) = 0;
};

/// `current` if it can, or else the lowest block that can.
std::uint32_t next_by_default(const std::vector<BlockState>& blocks, std::uint32_t current);

class Interleaver {
 public:
    /// `memory` belongs to the device that runs the kernels.
    explicit Interleaver(const MemoryChecker& memory) : memory_(memory) {}
    Interleaver(const Interleaver&) = delete;
    Interleaver& operator=(const Interleaver&) = delete;

    void use(Chooser& chooser) { chooser_ = &chooser; }
    /// Runs a launch. Throws what its blocks throw; LaunchError where all wait for each other.
    void run(const Launch& launch);
    /// Called by the instrumented kernel.
    void on_access(Access access, const void* address, std::size_t bytes);

 private:
    void resume(std::uint32_t block);
    /// Whether the running thread reads what it has read before, unchanged since.
    bool reads_again(std::uint32_t word);
    void release_one();

    struct Seen {
        std::uint32_t word = ~0u;
        std::uint32_t version = 0;
    };

    const MemoryChecker& memory_;
    Chooser* chooser_ = nullptr;
    std::vector<std::unique_ptr<BlockRunner>> runners_;
    std::vector<std::unique_ptr<Fiber>> fibers_;
    std::vector<BlockState> states_;
    std::uint32_t current_ = 0;
    std::unordered_map<std::uint32_t, std::uint32_t> versions_;  ///< changes, by word
    std::unordered_map<std::uint64_t, Seen> seen_;               ///< relaxed reads, by thread
    std::vector<std::uint32_t> waited_word_;
    std::uint32_t releases_ = 0;  ///< in a row, with no write between
};

}  // namespace scotty::emulation::simt
