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
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "emulation/simt/check/mapped_memory.h"
#include "emulation/simt/shared_memory.h"

namespace scotty::emulation::simt {

enum class Access : std::uint8_t { read, write, atomic, relaxed_read };

/// One access, in 16 bytes: two of them are compared without unpacking more than they must.
struct Stamp {
    std::uint32_t launch = 0;  ///< counted from 1; 0: none
    std::uint32_t block = 0;
    std::uint32_t place = 0;  ///< offset of the access in the program's text
    std::uint32_t when = 0;   ///< phase << 12 | several blocks | several threads | thread
};

/// The last accesses to four bytes, one of each kind.
struct alignas(64) Shadow {
    Stamp of[4];
};

/// Of the thread that runs, as far as it changes with every access.
struct Accessor {
    std::uint32_t launch = 0;
    std::uint32_t block = 0;
    std::uint32_t thread = 0;
    std::uint32_t phase = 0;
};

/// Two accesses that conflict, or one that should not have been.
struct MemoryFinding {
    enum class Kind : std::uint8_t { race, foreign, twice, unwritten, outside, freed };
    Kind kind = Kind::race;
    Access access = Access::read;
    std::uint32_t block = 0;
    std::uint32_t thread = 0;
    std::uint32_t place = 0;
    // Of a race, and of a slot written twice: the other one.
    Access other_access = Access::read;
    std::uint32_t other_block = 0;
    std::uint32_t other_thread = 0;
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

    /// Its number, for Accessor::launch.
    std::uint32_t begin_launch(const char* kernel);
    /// What was found since the last call, the same place of the text once.
    std::vector<MemoryFinding> take_findings();

    /// A thread has touched another's register (PerThread). On any worker.
    void report_register(const Accessor& who, std::uint32_t owner, const void* place);

    /// From the instrumented kernel, on any worker. `shared` and `shared_shadow`: of its block.
    /// Addresses that are neither device nor shared memory are the thread's own affair.
    void on_access(Access access, const void* address, std::size_t bytes, const void* place,
                   const Accessor& who, const SharedMemory& shared, Shadow* shared_shadow) {
        const auto at = reinterpret_cast<std::uintptr_t>(address);
        const std::uintptr_t offset = at - begin_;
        if (offset < kDeviceBytes) {
            check_device(access, offset, bytes, offset_in_text(place), who);
            return;
        }
        const std::uintptr_t in_block = at - reinterpret_cast<std::uintptr_t>(shared.memory());
        if (in_block < SharedMemory::kBytes) {
            check_shared(access, in_block, bytes, offset_in_text(place), who, shared,
                         shared_shadow);
        }
    }

    /// kDeviceBytes or more: no device memory.
    std::uintptr_t offset_of(const void* address) const {
        return reinterpret_cast<std::uintptr_t>(address) - begin_;
    }

    /// What the pretended device has.
    static constexpr std::size_t kDeviceBytes = std::size_t{1} << 32;

 private:
    enum State : std::uint8_t { nobodys, freed, unwritten, written, unwritten_once, written_once };
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
    void check_device(Access access, std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                      const Accessor& who);
    void check_shared(Access access, std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                      const Accessor& who, const SharedMemory& shared, Shadow* shadows);
    /// Whether a word that is not simply written may be touched so; notes that it has been.
    bool settle(Access access, std::size_t word, std::uint32_t place, const Accessor& who);
    /// `shared`: null for device memory. `other`: of a race.
    void report(MemoryFinding::Kind kind, Access access, std::uint32_t place, const Accessor& who,
                const Stamp* other, Access other_access, std::uintptr_t offset,
                const SharedMemory* shared);
    std::optional<Writer> writer_of(std::size_t word) const;
    /// With findings_mutex_ held, or while no kernel runs.
    std::string name_of(std::uintptr_t offset) const;

    MappedMemory memory_;
    MappedMemory shadow_memory_;
    MappedMemory state_memory_;
    std::uintptr_t begin_ = 0;
    std::uintptr_t text_begin_ = 0;
    Shadow* shadows_ = nullptr;
    std::uint8_t* states_ = nullptr;
    std::size_t used_ = kGuard;
    std::map<std::uintptr_t, Allocation> allocations_;  ///< by offset; kept when freed, for reports
    std::vector<Download> downloads_;
    std::vector<std::string> kernels_;  ///< by launch - 1

    std::mutex findings_mutex_;
    std::vector<MemoryFinding> findings_;
    std::set<std::uint64_t> reported_;  ///< pairs of places of this launch
};

}  // namespace scotty::emulation::simt
