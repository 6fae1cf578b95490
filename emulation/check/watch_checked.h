/// The emulator under the checker: which thread runs, in which phase, on which memory. The checked
/// build's half of emulation/device/watch.h, which includes it.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "emulation/check/bad_address.h"
#include "emulation/check/memory_checker.h"
#include "emulation/check/unheard.h"
#include "emulation/execution/buffer_use.h"
#include "emulation/execution/context.h"
#include "emulation/execution/schedule.h"
#include "emulation/execution/shared_memory.h"
#include "reference/contract/launch_record.h"

namespace scotty::emulation {

/// What determines the order of a block's threads.
struct Turns {
    Schedule schedule;
    std::uint64_t launch = 0;
};

/// A device's checker, and the state of its workers.
class Watch {
    /// Shared memory of the blocks that a worker runs one after the other.
    struct Worker {
        simt::SharedMemory shared;
        std::vector<simt::SharedShadow> shadow =
            std::vector<simt::SharedShadow>(simt::SharedMemory::kBytes / 4);
    };

 public:
    Watch();
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    class InBlock {
     public:
        InBlock(Watch& watch, std::uint32_t index, std::uint32_t threads);
        ~InBlock();
        InBlock(const InBlock&) = delete;
        InBlock& operator=(const InBlock&) = delete;
    };
    /// `run()` runs the blocks of the launch. Throws LaunchError for findings in them.
    void run_launch(std::uint32_t blocks, std::uint32_t threads, const Schedule& schedule,
                    std::uint64_t launch, const std::function<void()>& run);
    static void name_launch(reference::StageKind kind, const reference::StagePlace& place,
                            std::size_t launch);

    /// Code between phases is a phase of its own, in which thread 0 does the block's work.
    static void begin_phase() { end_turn(); }
    static void begin_thread(std::uint32_t thread) {
        simt::store_unheard(simt::context.thread, thread);
    }
    static void end_turn() {
        simt::store_unheard(simt::context.phase, simt::load_unheard(simt::context.phase) + 1);
    }
    static void end_phase() {
        end_turn();
        begin_thread(0);
    }
    /// Runs the threads of a phase in the schedule's order.
    template <class Body>
    static void each_thread(std::uint32_t active, Body& body) {
        const bool ascending = is_ascending();
        for (std::uint32_t i = 0; i < active; ++i) {
            const std::uint32_t thread = ascending ? i : turn(i, active);
            begin_thread(thread);
            body(thread);
        }
    }
    /// Threads are not announced, so that the loop vectorises: accesses are findings.
    static void begin_registers();
    static void end_registers();
    template <class Body>
    static void each_thread_on_registers(std::uint32_t active, Body& body) {
        if (is_ascending()) {
            for (std::uint32_t thread = 0; thread < active; ++thread) body(thread);
        } else {
            for (std::uint32_t i = 0; i < active; ++i) body(turn(i, active));
        }
    }
    /// Flattening turns registers into locals that no call sees, which then need no watching and
    /// cost nothing.
    template <class Kernel, class Block>
    [[gnu::flatten]] static void run_threads(Kernel& kernel, const Block& block) {
        kernel(block);
    }
    template <class Kernel, class Block>
    void run_block(Kernel& kernel, const Block& block) {
        const std::string bad = simt::bad_address_in([&] { run_threads(kernel, block); });
        if (!bad.empty()) fail_block(bad);
    }
    static void own_register(std::uint32_t thread) {
        if (thread != simt::load_unheard(simt::context.thread)) foreign_register(thread);
    }

    simt::MemoryChecker& checker() { return *checker_; }
    /// The checker of this host thread's latest device, or null.
    static simt::MemoryChecker* latest();

 private:
    static bool is_ascending();
    static std::uint32_t turn(std::uint32_t i, std::uint32_t active);
    [[gnu::noinline]] static void foreign_register(std::uint32_t owner);
    [[noreturn]] void fail_block(const std::string& why) const;

    std::unique_ptr<simt::MemoryChecker> checker_;
    oneapi::tbb::enumerable_thread_specific<Worker> workers_;
    std::string kernel_;  ///< of the running launch, as reports call it
    Turns turns_;
    std::uint32_t first_block_ = 0;  ///< of the launch
    std::uint32_t threads_ = 0;
};

template <class T>
struct WatchedMemory {
    /// Memory from the checker, or plain memory without a watch.
    struct Release {
        simt::MemoryChecker* checker = nullptr;
        void operator()(T* memory) const {
            if (checker == nullptr) {
                delete[] memory;
            } else {
                checker->release(memory);
            }
        }
    };
    using Pointer = std::unique_ptr<T[], Release>;
    static Pointer allocate(Watch* watch, std::size_t count, const char* name, BufferUse use) {
        if (watch == nullptr) return Pointer(new T[count]);
        auto* memory = static_cast<T*>(watch->checker().allocate_or_throw(count * sizeof(T), name));
        discard(watch, memory, count, use);
        return Pointer(memory, Release{&watch->checker()});
    }
    static void host_wrote(Watch* watch, const T* memory, std::size_t count) {
        if (watch != nullptr) watch->checker().note_upload(memory, count * sizeof(T));
    }
    static void discard(Watch* watch, const T* memory, std::size_t count, BufferUse use) {
        if (watch == nullptr) return;
        watch->checker().discard(memory, count * sizeof(T), use == BufferUse::each_slot_once);
    }
};

template <class T, std::uint32_t Count>
struct WatchedShared {
    explicit WatchedShared(const char* name)
        : values(static_cast<T*>(
              simt::context.shared->object(name, name, Count * sizeof(T), alignof(T)))) {}
    T* values;
};

}  // namespace scotty::emulation
