/// Runs the blocks of a launch in turns that change in their middle, each block a fiber.
///
/// The instrumented kernel reports every access to device memory (check/instrumentation.cpp) before
/// it happens. There a block may stand, and another goes on. Which, a Chooser says.
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
/// reads; an atomic writes, whatever comes of it.
struct Touch {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    bool writes = false;

    bool operator==(const Touch&) const = default;
};
inline bool dependent(const Touch& a, const Touch& b) {
    return a.first <= b.last && b.first <= a.last && (a.writes || b.writes);
}

/// Where the blocks of a launch stand.
struct BlockState {
    bool begun = false;
    bool over = false;
    /// It has read a word that nobody has changed since it last read it: it waits for others.
    bool waits = false;
    std::uint32_t accesses = 0;  ///< begun, the one included before which it stands
    Touch next;                  ///< what it is about to do, where it stands

    bool can_run() const { return !over && !waits; }
};

class Chooser {
 public:
    Chooser() = default;
    Chooser(const Chooser&) = delete;
    Chooser& operator=(const Chooser&) = delete;
    virtual ~Chooser() = default;

    /// Before anything runs.
    virtual void begin(const Launch& launch) = 0;
    /// Whether all blocks run to their first stop before the first choice.
    virtual bool begins_all() const = 0;
    /// Whether the running block stands before this, its `access`-th access.
    virtual bool stops(std::uint32_t block, std::uint32_t access, const Touch& touch) = 0;
    /// Who goes on: one that can_run(). `current` ran last. Some block can.
    virtual std::uint32_t choose(const std::vector<BlockState>& blocks, std::uint32_t current) = 0;
};

/// `current` if it can, or else the lowest block that can.
std::uint32_t next_by_default(const std::vector<BlockState>& blocks, std::uint32_t current);

class Interleaver {
 public:
    /// Of the device whose memory that is.
    explicit Interleaver(const MemoryChecker& memory) : memory_(memory) {}
    Interleaver(const Interleaver&) = delete;
    Interleaver& operator=(const Interleaver&) = delete;

    void use(Chooser& chooser) { chooser_ = &chooser; }
    /// A whole launch. Throws what its blocks throw, and LaunchError where all wait for each other.
    void run(const Launch& launch);
    /// From the instrumented kernel.
    void on_access(Access access, const void* address, std::size_t bytes);

 private:
    void resume(std::uint32_t block);
    /// The running thread reads what it has read before, unchanged since.
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
    std::uint32_t releases_ = 0;  ///< one after the other, of blocks that waited for nobody
};

}  // namespace scotty::emulation::simt
