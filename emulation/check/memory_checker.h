/// Watches every load and store of the kernels: races, unwritten memory, memory that is not theirs.
///
/// What a kernel touches is reported by code that the compiler puts in front of each access
/// (instrumentation.cpp). For every four bytes of device and shared memory the checker remembers
/// the last plain read, plain write, atomic and relaxed read, each with launch, block, thread,
/// phase (barriers passed) and place in the text. Two accesses of one launch conflict where one of
/// them is a plain write, or one plain and one atomic, and nothing orders them: other blocks are
/// never ordered, other threads of a block by a barrier between. Nothing has to go wrong for that
/// to show, and the order in which threads ran does not matter but for which of a pair is named.
///
/// Warp collectives order no memory, as on the device. Bytes of one word count as one location.
///
/// What that costs is memory traffic: what is remembered of plain accesses is kept apart from what
/// is remembered of the others, which few words ever have, and is written only where it changes.
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

/// The upper bit: which Shadow of a word; the lower: which half of it.
enum class Access : std::uint8_t { read, write, relaxed_read, atomic };

/// The thread that runs.
struct Accessor {
    explicit Accessor(const Context& running)
        : launch(Stamp{running.first_block} << kBlockShift),
          now((Stamp{running.first_block} + running.block) << kBlockShift |
              static_cast<std::uint32_t>(running.phase << kPhaseShift) | running.thread) {}
    Stamp launch;  ///< not greater than any of its launch, greater than all before
    Stamp now;
};

/// Two accesses that conflict, or one that should not have been.
struct MemoryFinding {
    enum class Kind : std::uint8_t { race, foreign, no_register, twice, unwritten, outside, freed };
    Kind kind = Kind::race;
    Access access = Access::read;
    std::uint32_t block = 0;
    std::uint32_t thread = 0;  ///< kSomeOther: in a phase on registers
    std::uint32_t place = 0;
    // Of a race, and of a slot written twice: the other one.
    Access other_access = Access::read;
    std::uint32_t other_block = 0;   ///< kSomeOther: of several, only this one is still known
    std::uint32_t other_thread = 0;  ///< the same
    std::uint32_t other_place = 0;
    std::string memory;  ///< "child_queue, byte 64 of 4096" or "shared memory, byte 12"
};
/// "data race on shared memory of the block, byte 12: thread 3 of block 0 writes it at gpu/a.h:10,
/// thread 5 of block 0 reads it at gpu/a.h:12".
std::string to_text(const MemoryFinding& finding);

class MemoryChecker;
/// Runs a launch's blocks, and fails it for what was found in them: a LaunchError. If they have
/// thrown one, that ends its message, or, with nothing found, is thrown on.
void throw_findings_of(MemoryChecker& checker, const std::string& kernel, std::uint32_t threads,
                       const std::function<void()>& run_blocks);

/// Reads that others may overtake (load_relaxed), by their place in the text.
struct RelaxedMeetings {
    std::string line;
    std::uint64_t met = 0;  ///< how often nothing ordered one of them and an atomic of its launch
};
/// Of all checkers of this process so far, by line.
std::vector<RelaxedMeetings> relaxed_meetings();

/// Who wrote a word last.
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
    /// Address space set aside, not memory used. Throws missing_environment where the system
    /// refuses it.
    MemoryChecker();
    ~MemoryChecker();
    MemoryChecker(const MemoryChecker&) = delete;
    MemoryChecker& operator=(const MemoryChecker&) = delete;

    // The memory of the pretended device. One host thread; no kernel runs.

    /// Unwritten memory with a guard on either side; null where there is no room.
    void* allocate(std::size_t bytes);
    /// The same with a name; throws missing_environment where there is no room.
    void* allocate_or_throw(std::size_t bytes, const char* name);
    /// Nobody needs what is in it: unwritten again. `each_slot_once`: from now on a second write to
    /// a place is a finding.
    void discard(const void* memory, std::size_t bytes, bool each_slot_once);
    /// False: the memory is not from here.
    bool release(void* memory);
    /// Nobody holds memory any more: the next allocation is where the first was.
    void forget_all();
    /// What reports call it.
    void label(const void* memory, const char* name);
    /// The host has written here.
    void note_upload(const void* to, std::size_t bytes);
    /// The host has a copy: so that last_writer() finds where it is from. Until the next launch.
    void note_download(const void* host, const void* device, std::size_t bytes);

    /// The kernel that wrote a word of device memory, or of a host copy of it; none where it was
    /// not a kernel.
    std::optional<Writer> last_writer(const void* host) const;

    // Launches.

    /// The number of its first block, for Context. Throws missing_environment after billions
    /// of blocks.
    std::uint32_t begin_launch(const char* kernel, std::uint32_t blocks);
    /// What was found since the last call, the same place of the text once.
    std::vector<MemoryFinding> take_findings();

    /// A thread has touched another's register (PerThread). On any worker.
    void report_register(const Context& running, std::uint32_t owner, const void* place);

    /// From the instrumented kernel, on any worker. Addresses that are neither device memory nor
    /// shared memory of the block are the thread's own affair.
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

    /// kDeviceBytes or more: no device memory.
    std::uintptr_t offset_of(const void* address) const {
        return reinterpret_cast<std::uintptr_t>(address) - begin_;
    }

    /// What the pretended device has.
    static constexpr std::size_t kDeviceBytes = CheckerMemory::kDeviceBytes;

 private:
    /// Of a word, as bits.
    enum State : std::uint8_t {
        kNobodys = 0,
        kOwned = 1,
        kWritten = 2,
        kOnce = 4,    ///< a second write is a finding
        kOthers = 8,  ///< since it was unwritten, somebody touched it otherwise than plainly
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
    /// An access that is not plain, or a plain one to a word that has such.
    template <Access access>
    [[gnu::noinline]] void check_others(std::size_t word, std::uint32_t place,
                                        const Context& running);
    /// `offset`: in device memory, or in the shared memory given.
    /// The access against one kind of those before.
    template <bool shared, Access access, Access other>
    void check_pair(const Shadow& shadow, std::uint32_t place, Accessor who, std::uintptr_t offset,
                    const SharedMemory* memory, const Context& running);
    template <bool shared, Access access>
    void check_all(Shadow& plain, Shadow& others, std::uint32_t place, Accessor who,
                   std::uintptr_t offset, const SharedMemory* memory, const Context& running);
    /// Whether a word that is not simply written may be touched so; notes that it has been.
    [[gnu::noinline]] bool settle(Access access, std::size_t word, std::uint32_t place,
                                  const Context& running);
    /// `shared`: null for device memory. `other`: of a race, or of a slot
    /// written twice.
    struct Other {
        Access access;
        Stamp stamp;
        std::uint32_t place;
    };
    [[gnu::cold]] void report(MemoryFinding::Kind kind, Access access, std::uint32_t place,
                              const Context& running, const Other* other, std::uintptr_t offset,
                              const SharedMemory* shared);
    /// Null: not of this checker.
    const LaunchOfBlocks* launch_of(Stamp stamp) const;
    std::optional<Writer> writer_of(std::size_t word) const;
    /// With findings_mutex_ held, or while no kernel runs.
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
