/// Watches every load and store of the kernels: races, unwritten memory, memory that is not theirs.
///
/// The compiler puts code in front of each access that announces it (instrumentation.cpp). For
/// every four bytes of device and shared memory the checker remembers the last plain read, plain
/// write, atomic and relaxed read, each with launch, block, thread, phase (barriers passed) and
/// place in the text. Two accesses of one launch conflict if one of them is a plain write, or one
/// is plain and one atomic, and nothing orders them: nothing orders two blocks, and only a barrier
/// orders two threads of a block. A race need not do harm to be found, and the order in which
/// threads ran only decides which of a pair is named.
///
/// Warp collectives order no memory, as on the device. Bytes of one word count as one location.
///
/// The price is memory traffic: plain accesses have a shadow of their own, apart from the others,
/// which few words ever have, and it is written only where it changes.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "emulation/check/checker_memory.h"
#include "emulation/execution/context.h"
#include "emulation/execution/shared_memory.h"

namespace scotty::emulation::simt {

/// The upper bit chooses the Shadow of a word, the lower bit its half.
enum class Access : std::uint8_t { read, write, relaxed_read, atomic };

/// The running thread.
struct Accessor {
    explicit Accessor(const Context& running)
        : launch(Stamp{running.first_block} << kBlockShift),
          now((Stamp{running.first_block} + running.block) << kBlockShift |
              static_cast<std::uint32_t>(running.phase << kPhaseShift) | running.thread) {}
    Stamp launch;  ///< at most the stamps of its launch, above all earlier ones
    Stamp now;
};

/// Two accesses that conflict, or one that breaks a rule.
struct MemoryFinding {
    enum class Kind : std::uint8_t { race, foreign, no_register, twice, unwritten, outside, freed };
    Kind kind = Kind::race;
    Access access = Access::read;
    std::uint32_t block = 0;
    std::uint32_t thread = 0;  ///< kSomeOther in a phase on registers
    std::uint32_t place = 0;
    // The other access of a race or of a slot written twice.
    Access other_access = Access::read;
    std::uint32_t other_block = 0;   ///< kSomeOther: only the finding's own is known
    std::uint32_t other_thread = 0;  ///< the same
    std::uint32_t other_place = 0;
    std::string memory;  ///< "child_queue, byte 64 of 4096" or "shared memory, byte 12"
};
/// "data race on shared memory of the block, byte 12: thread 3 of block 0 writes it at gpu/a.h:10,
/// thread 5 of block 0 reads it at gpu/a.h:12".
std::string to_text(const MemoryFinding& finding);

class MemoryChecker;
/// Runs a launch's blocks and fails it with a LaunchError for findings in them. An error that the
/// blocks threw ends the message; without findings it is thrown on.
void throw_findings_of(MemoryChecker& checker, const std::string& kernel, std::uint32_t threads,
                       const std::function<void()>& run_blocks);

/// Reads that other threads may overtake (load_relaxed), by their place in the text.
struct RelaxedMeetings {
    std::string line;
    std::uint64_t met = 0;  ///< how often nothing ordered one and an atomic of its launch
};
/// The reads of all checkers of this process so far, by line.
std::vector<RelaxedMeetings> relaxed_meetings();

/// The last writer of a word.
struct Writer {
    std::string kernel;
    bool in_last_launch = false;
    bool atomically = false;
    std::uint32_t block = 0;
    std::uint32_t thread = 0;
    std::uint32_t place = 0;
};

class MemoryChecker {
 public:
    /// Reserves address space, not memory. Throws missing_environment if the system refuses it.
    MemoryChecker();
    ~MemoryChecker();
    MemoryChecker(const MemoryChecker&) = delete;
    MemoryChecker& operator=(const MemoryChecker&) = delete;

    // The simulated device's memory. One host thread calls these while no kernel runs.

    /// Returns unwritten memory with a guard on either side, or null if there is no room.
    void* allocate(std::size_t bytes);
    /// The same with a name; throws missing_environment where there is no room.
    void* allocate_or_throw(std::size_t bytes, const char* name);
    /// The content is no longer needed: the memory is unwritten again. With `each_slot_once` a
    /// second write to a place is a finding from now on.
    void discard(const void* memory, std::size_t bytes, bool each_slot_once);
    /// Returns false if the memory is not from here.
    bool release(void* memory);
    /// No allocation is left: the next one is placed where the first was.
    void forget_all();
    /// Sets the name that reports use.
    void label(const void* memory, const char* name);
    /// The host has written here.
    void note_upload(const void* to, std::size_t bytes);
    /// The host has a copy: last_writer() finds its origin, until the next launch.
    void note_download(const void* host, const void* device, std::size_t bytes);

    /// The kernel that wrote a word of device memory, or of a host copy of it; nothing if no kernel
    /// wrote it.
    std::optional<Writer> last_writer(const void* host) const;

    // Launches.

    /// Returns the number of the launch's first block, for Context. Throws missing_environment
    /// after billions of blocks.
    std::uint32_t begin_launch(const char* kernel, std::uint32_t blocks);
    /// The findings since the last call, one per place in the text.
    std::vector<MemoryFinding> take_findings();

    /// A block is over: reports what it has written between two objects of shared memory. Any
    /// worker may call it.
    void end_block(const Context& running);

    /// A thread has touched another's register (PerThread). Any worker may call it.
    void report_register(const Context& running, std::uint32_t owner, const void* place);

    /// Called by the instrumented kernel, on any worker. Addresses outside device memory and the
    /// block's shared memory belong to the thread alone.
    template <Access access>
    void on_access(const void* address, std::size_t bytes, const void* place,
                   const Context& running) {
        const auto at = reinterpret_cast<std::uintptr_t>(address);
        const std::uintptr_t offset = at - begin_;
        if (offset < kDeviceBytes) {
            check_device<access>(offset, bytes, offset_in_text(place), running);
            return;
        }
        const std::uintptr_t in_block =
            at - reinterpret_cast<std::uintptr_t>(running.shared->memory());
        if (in_block < SharedMemory::kBytes) {
            check_shared<access>(in_block, bytes, offset_in_text(place), running);
        }
    }

    /// A thread touches memory in a phase on registers.
    void report_memory(Access access, const void* address, const void* place,
                       const Context& running);

    /// The result is kDeviceBytes or more for other memory.
    std::uintptr_t offset_of(const void* address) const {
        return reinterpret_cast<std::uintptr_t>(address) - begin_;
    }

    /// The size of the simulated device's memory.
    static constexpr std::size_t kDeviceBytes = CheckerMemory::kDeviceBytes;

 private:
    /// Bits of a word's state.
    enum State : std::uint8_t {
        kNobodys = 0,
        kOwned = 1,
        kWritten = 2,
        kOnce = 4,    ///< a second write is a finding
        kOthers = 8,  ///< some thread has accessed it otherwise than plainly
        kFreed = 16,
    };
    struct LaunchOfBlocks {
        std::uint32_t first;  ///< block
        std::string kernel;
    };
    struct Allocation {
        std::size_t bytes;
        std::string name;
    };
    struct Download {
        std::uintptr_t host;
        std::uintptr_t offset;
        std::size_t bytes;
    };
    static constexpr std::size_t kGuard = 4096;

    std::uint32_t offset_in_text(const void* place) const {
        return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(place) - text_begin_);
    }
    template <Access access>
    void check_device(std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                      const Context& running);
    template <Access access>
    void check_shared(std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                      const Context& running);
    /// Checks an access that is not plain, or a plain one to a word that has others.
    template <Access access>
    [[gnu::noinline]] void check_others(std::size_t word, std::uint32_t place,
                                        const Context& running);
    /// `offset` is in device memory, or in the given shared memory.
    /// Checks the access against one kind of earlier ones.
    template <bool shared, Access access, Access other>
    void check_pair(const Shadow& shadow, std::uint32_t place, Accessor who, std::uintptr_t offset,
                    const SharedMemory* memory, const Context& running);
    template <bool shared, Access access>
    void check_all(Shadow& plain, Shadow& others, std::uint32_t place, Accessor who,
                   std::uintptr_t offset, const SharedMemory* memory, const Context& running);
    /// Whether a word that is not simply written may be accessed so; records that it was.
    [[gnu::noinline]] bool settle(Access access, std::size_t word, std::uint32_t place,
                                  const Context& running);
    /// `shared` is null for device memory. `other` is the other access of a race, or of a slot
    /// written twice.
    struct Other {
        Access access;
        Stamp stamp;
        std::uint32_t place;
    };
    [[gnu::cold]] void report(MemoryFinding::Kind kind, Access access, std::uint32_t place,
                              const Context& running, const Other* other, std::uintptr_t offset,
                              const SharedMemory* shared);
    /// Null if the stamp is not this checker's.
    const LaunchOfBlocks* launch_of(Stamp stamp) const;
    std::optional<Writer> writer_of(std::size_t word) const;
    /// Called with findings_mutex_ held, or while no kernel runs.
    std::string name_of(std::uintptr_t offset) const;

    std::unique_ptr<CheckerMemory> memory_;
    std::uintptr_t begin_;
    std::uintptr_t text_begin_;
    Shadow* plain_;         ///< by word: read, write
    Shadow* others_;        ///< by word: relaxed read, atomic
    std::uint8_t* states_;  ///< by word
    std::size_t used_ = kGuard;
    std::map<std::uintptr_t, Allocation> allocations_;  ///< by offset; kept when freed, for reports
    std::vector<Download> downloads_;
    std::vector<LaunchOfBlocks> launches_;

    std::mutex findings_mutex_;
    std::vector<MemoryFinding> findings_;
    std::set<std::uint64_t> reported_;  ///< pairs of places of this launch
};

}  // namespace scotty::emulation::simt
