/// The machine that runs CUDA programs on one CPU thread: device memory, launches, threads, clocks.
///
/// A launch runs its blocks one after the other, in an order that replays. Each thread runs until
/// it waits, leaves, or has polled memory for some time; blocks that only poll stand aside for
/// others.
#pragma once

#include <csetjmp>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "emulation/cuda/device_memory.h"
#include "emulation/cuda/findings.h"
#include "emulation/cuda/races.h"
#include "emulation/cuda/threads.h"
#include "emulation/execution/schedule.h"
#include "emulation/execution/thread_order.h"

namespace scotty::emulation::cuda {

using scotty_cuda::Barrier;
using scotty_cuda::LaunchInfo;
using scotty_cuda::Order;
using scotty_cuda::Scope;
using scotty_cuda::Space;

/// CUDA's numbers of errors, as far as the machine makes them.
enum ErrorCode : int {
    kNoError = 0,
    kInvalidValue = 1,
    kOutOfMemory = 2,
    kInvalidConfiguration = 9,
    kInvalidPointer = 17,
    kIllegalAddress = 700,
    kLaunchTimeout = 702,
    kAssert = 710,
    kLaunchFailure = 719,
};

/// What atomics and fences pass on, by address.
struct Channel {
    SharedClocks device;
    std::map<std::uint32_t, SharedClocks> by_block;
};

class Machine {
 public:
    static Machine& get();

    // Host side.

    void launch(const LaunchInfo& info, void (*run)(void*), void* arguments);
    DeviceMemory& memory() { return memory_; }
    Findings& findings() { return findings_; }
    /// An error that stays until the program asks; illegal addresses stay for ever.
    int take_error();
    int error() const { return error_; }
    void set_error(int code) {
        if (error_ == kNoError) error_ = code;
    }
    /// A new context: illegal addresses are forgotten, too.
    void reset_error() {
        error_ = kNoError;
        sticky_ = false;
    }
    /// A call of the runtime that cannot be right.
    void report_call(FindingKind kind, const std::string& what, const void* place);
    void host_wrote(Region& region, const void* at, std::size_t bytes);
    /// Host code touches memory of the device.
    void host_access(const void* at, bool writes, const void* place);
    /// At the end of the program: looks for leaks, writes the report. Runs once.
    void finish();
    void register_variable(void* variable, std::size_t bytes, const char* name, Space space);

    // The running thread's side.

    /// `aligned`: one load or store, whose address must be a multiple of its size.
    void access(Access access, const void* address, std::size_t bytes, const void* place,
                bool block_scope = false, bool aligned = true);
    int barrier(Barrier kind, int predicate, const void* place);
    std::uint64_t warp(scotty_cuda::WarpOperation operation, std::uint32_t mask,
                       std::uint64_t value, std::uint32_t parameter, std::uint32_t width, int* flag,
                       const void* place);
    void atomic_begins(void* at, std::size_t bytes, bool reads, bool writes, Scope scope,
                       Order order, const void* place);
    void atomic_ends(bool changed);
    void fence(Scope scope, Order order);
    void* shared_object(const void* site, const char* name, std::size_t bytes,
                        std::size_t alignment);
    void* dynamic_shared();
    void leave(int line);
    void give_way();
    [[noreturn]] void end_thread(FindingKind kind, const std::string& why, std::uint32_t place,
                                 int code);
    std::uint64_t clock() { return clock_ += 16; }
    /// As scotty/kernels.h says. A kernel that has failed keeps others from running no longer.
    std::string take_findings(bool warnings) {
        sticky_ = false;
        error_ = kNoError;
        return findings_.take(warnings);
    }
    void use(const Schedule& schedule) { schedule_ = schedule; }

    std::uint32_t offset_in_text(const void* place) const {
        return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(place) - text_begin_);
    }
    static void enter_function(const void* caller, const void* entry);
    static void leave_function();
    /// The running function has copied a record: the loads and stores of its members were one.
    void record_copied(Access access, const void* record, std::size_t bytes, std::size_t alignment);

 private:
    Machine();

    // Scheduling (machine.cpp).
    void run_grid();
    Block* begin_block(std::uint32_t index);
    void end_block(Block* block);
    /// Runs the block until it is over (true) or only polls (false).
    bool run_block(Block& block);
    struct Turns {
        std::uint32_t ready = 0;  ///< threads that could go on
        bool polls = true;        ///< nobody did anything but poll
    };
    Turns run_ready_threads(Block& block, std::uint32_t warps);
    void resume(Thread& thread);
    void stop();
    static void thread_entry();
    bool waits_for_ever();
    void report_endless();

    // Waiting (waiting.cpp).
    bool release_warp(Block& block, std::uint32_t warp);
    void complete(Block& block, std::uint32_t warp, std::uint32_t lanes, std::uint32_t mask);
    bool release_active(Block& block);
    bool release_barrier(Block& block);
    void report_parted(Block& block, const std::string& what);
    void report_leavers(Block& block);
    void join_block(Block& block);
    void join_lanes(Block& block, std::uint32_t warp, std::uint32_t lanes);

    // Accesses (accesses.cpp).
    void check(Region& region, Access access, const std::byte* at, std::size_t bytes,
               std::uint32_t place, bool block_scope, bool aligned);
    void check_elsewhere(Access access, const std::byte* at, std::size_t bytes,
                         std::uint32_t place);
    void report_race(const Region& region, std::size_t byte, Access access, const Record& other,
                     std::uint32_t place, const std::byte* at, std::size_t bytes);
    void close_writes(Thread& thread);
    void may_poll(Thread& thread);
    Region* shared_region(Block& block, const std::byte* at);
    SharedClocks knowledge(const Thread& thread) const;

    Actor actor(const Thread& thread, std::uint32_t place, const char* does) const;
    Actor actor(const Record& record) const;
    std::string memory_text(const Region& region, std::size_t byte) const;
    Finding memory_finding(FindingKind kind, const Region* region, const std::string& what,
                           Access access, std::uint32_t place) const;
    void report_unsure_reads(Thread& thread);
    void report_memory(FindingKind kind, const Region* region, const std::string& what,
                       Access access, std::uint32_t place);

    std::uintptr_t text_begin_;
    DeviceMemory memory_;
    Findings findings_;
    StackPool stacks_;
    Stack scheduler_;

    Schedule schedule_;
    std::string report_file_;
    bool strict_ = false;
    bool finished_ = false;

    // The running launch.
    LaunchInfo info_;
    void (*run_)(void*) = nullptr;
    void* arguments_ = nullptr;
    std::uint32_t launch_ = 0;
    std::vector<std::uint32_t> order_;
    std::size_t next_block_ = 0;
    std::deque<std::unique_ptr<Block>> resident_;
    std::vector<std::unique_ptr<Block>> free_blocks_;
    std::size_t resident_threads_ = 0;
    bool aborted_ = false;
    std::uint64_t changes_ = 0;  ///< of memory and of waiting threads
    std::uint64_t idle_turns_ = 0;
    std::uint64_t changes_seen_ = 0;
    std::unordered_map<const void*, Channel> channels_;
    simt::ThreadOrder thread_order_;
    sigjmp_buf way_out_{};

    int error_ = kNoError;
    bool sticky_ = false;
    std::uint64_t clock_ = 0;
};

/// The CUDA thread that runs on this host thread; null in host code.
extern thread_local constinit Thread* current_thread;

Dim block_of(std::uint32_t index, const Dim& grid);

}  // namespace scotty::emulation::cuda
