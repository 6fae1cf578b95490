// What instrumented programs call: before every access (-fsanitize=thread puts the calls there, and
// the program is linked without the sanitizer's library), in place of memcpy, malloc and their kin,
// and for what a failed assertion does.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "emulation/cuda/machine.h"

using scotty::emulation::cuda::Access;
using scotty::emulation::cuda::current_thread;
using scotty::emulation::cuda::FindingKind;
using scotty::emulation::cuda::Machine;
using scotty::emulation::cuda::Region;
using scotty::emulation::cuda::RegionKind;

namespace {

/// Where the arena lies, as soon as there is a machine: host code asks at every access.
bool in_arena(const void* address) { return Machine::get().memory().in_arena(address); }

inline void note(Access access, const void* address, std::size_t bytes, const void* place,
                 bool aligned = true) {
    if (current_thread != nullptr) {
        Machine::get().access(access, address, bytes, place, false, aligned);
        return;
    }
    if (in_arena(address)) {
        Machine::get().host_access(
            address, access == Access::write || access == Access::volatile_write, place);
    }
}

/// Copies may touch much: a kernel's is looked at as a whole.
void note_copy(void* to, const void* from, std::size_t bytes, const void* place) {
    if (bytes == 0) return;
    note(Access::read, from, bytes, place, false);
    note(Access::write, to, bytes, place, false);
}

void* kernel_heap(std::size_t bytes, const void* place) {
    Machine& machine = Machine::get();
    return machine.memory().allocate(bytes == 0 ? 1 : bytes, RegionKind::heap,
                                     machine.offset_in_text(place), false);
}

bool free_in_kernel(void* memory, const void* place) {
    Machine& machine = Machine::get();
    if (!machine.memory().in_arena(memory)) return false;
    Region* const region = machine.memory().find(memory);
    if (region == nullptr || region->begin != memory || region->kind != RegionKind::heap) {
        machine.report_call(FindingKind::call, "free of what malloc did not give", place);
    } else if (region->freed) {
        machine.report_call(FindingKind::freed, "memory of the kernel's malloc is freed twice",
                            place);
    } else {
        machine.memory().release(*region, machine.offset_in_text(place));
    }
    return true;
}

struct Hooks {
    static void read(const void* a, std::size_t bytes, const void* place, bool aligned) {
        note(Access::read, a, bytes, place, aligned);
    }
    static void write(const void* a, std::size_t bytes, const void* place, bool aligned) {
        note(Access::write, a, bytes, place, aligned);
    }
    static void volatile_read(const void* a, std::size_t bytes, const void* place, bool aligned) {
        note(Access::volatile_read, a, bytes, place, aligned);
    }
    static void volatile_write(const void* a, std::size_t bytes, const void* place, bool aligned) {
        note(Access::volatile_write, a, bytes, place, aligned);
    }
    static void atomic(const void* a, std::size_t bytes, const void* place) {
        note(Access::atomic, a, bytes, place);
    }
    static void atomic_load(const void* a, std::size_t bytes, const void* place) {
        note(Access::atomic_load, a, bytes, place);
    }
};

}  // namespace

#include "emulation/check/compiler_hooks.h"

// The names and the types are the compiler's and the C library's.
// NOLINTBEGIN
extern "C" {
void __tsan_atomic_thread_fence(int) {}
void __tsan_func_entry(void* caller) {
    if (current_thread != nullptr) Machine::enter_function(caller, SCOTTY_PLACE);
}
void __tsan_func_exit() {
    if (current_thread != nullptr) Machine::leave_function();
}
void __tsan_vptr_update(void** a, void*) { note(Access::write, a, sizeof *a, SCOTTY_PLACE); }
void __tsan_vptr_read(void** a) { note(Access::read, a, sizeof *a, SCOTTY_PLACE); }

// The linker sends the program's calls of memcpy and others here (--wrap), and not the library's
// own.
void* __wrap_memcpy(void* to, const void* from, std::size_t bytes) {
    note_copy(to, from, bytes, SCOTTY_PLACE);
    return std::memcpy(to, from, bytes);
}
void* __wrap_memmove(void* to, const void* from, std::size_t bytes) {
    note_copy(to, from, bytes, SCOTTY_PLACE);
    return std::memmove(to, from, bytes);
}
void* __wrap_memset(void* to, int value, std::size_t bytes) {
    if (bytes != 0) note(Access::write, to, bytes, SCOTTY_PLACE, false);
    return std::memset(to, value, bytes);
}
void* __wrap_malloc(std::size_t bytes) {
    return current_thread != nullptr ? kernel_heap(bytes, SCOTTY_PLACE) : std::malloc(bytes);
}
void __wrap_free(void* memory) {
    if (memory == nullptr || (current_thread != nullptr && free_in_kernel(memory, SCOTTY_PLACE))) {
        return;
    }
    if (in_arena(memory)) {
        Machine::get().report_call(FindingKind::call, "free of device memory on the host",
                                   SCOTTY_PLACE);
        return;
    }
    std::free(memory);
}
void* __wrap__Znwm(std::size_t bytes) {
    return current_thread != nullptr ? kernel_heap(bytes, SCOTTY_PLACE) : ::operator new(bytes);
}
void* __wrap__Znam(std::size_t bytes) {
    return current_thread != nullptr ? kernel_heap(bytes, SCOTTY_PLACE) : ::operator new[](bytes);
}
#define SCOTTY_DELETE(name, parameters, arguments)                                     \
    void __wrap_##name parameters {                                                    \
        if (memory == nullptr) return;                                                 \
        if (current_thread != nullptr && free_in_kernel(memory, SCOTTY_PLACE)) return; \
        arguments;                                                                     \
    }
SCOTTY_DELETE(_ZdlPv, (void* memory), ::operator delete(memory))
SCOTTY_DELETE(_ZdaPv, (void* memory), ::operator delete[](memory))
SCOTTY_DELETE(_ZdlPvm, (void* memory, std::size_t), ::operator delete(memory))
SCOTTY_DELETE(_ZdaPvm, (void* memory, std::size_t), ::operator delete[](memory))

[[noreturn]] void __assert_fail(const char* what, const char* file, unsigned line,
                                const char* function);
[[noreturn]] void __wrap___assert_fail(const char* what, const char* file, unsigned line,
                                       const char* function) {
    if (current_thread == nullptr) __assert_fail(what, file, line, function);
    Machine& machine = Machine::get();
    machine.end_thread(FindingKind::assertion, what, machine.offset_in_text(SCOTTY_PLACE),
                       scotty::emulation::cuda::kAssert);
}
}
// NOLINTEND

// What CUDA text calls by way of scotty_cuda/cuda.h.
namespace scotty_cuda {

void launch(const LaunchInfo& info, void (*thread)(void* arguments), void* arguments) {
    show_grid(info.block, info.grid);
    Machine::get().launch(info, thread, arguments);
}
int barrier(Barrier kind, int predicate, const void* place) {
    return Machine::get().barrier(kind, predicate, place);
}
uint64_t warp(WarpOperation operation, uint32_t mask, uint64_t value, uint32_t parameter,
              uint32_t width, int* flag, const void* place) {
    return Machine::get().warp(operation, mask, value, parameter, width, flag, place);
}
void atomic_begins(void* address, size_t bytes, bool reads, bool writes, Scope scope, Order order,
                   const void* place) {
    if (current_thread == nullptr) {
        if (in_arena(address)) Machine::get().host_access(address, writes, place);
        return;
    }
    Machine::get().atomic_begins(address, bytes, reads, writes, scope, order, place);
}
void atomic_ends(bool changed) {
    if (current_thread != nullptr) Machine::get().atomic_ends(changed);
}
void fence(Scope scope, Order order) {
    if (current_thread != nullptr) Machine::get().fence(scope, order);
}
void* shared_object(const void* site, const char* name, size_t bytes, size_t alignment) {
    return Machine::get().shared_object(site, name, bytes, alignment);
}
void* dynamic_shared() { return Machine::get().dynamic_shared(); }
void leave(const char*, int line) {
    if (current_thread != nullptr) Machine::get().leave(line);
}
void register_variable(void* variable, size_t bytes, const char* name, Space space) {
    Machine::get().register_variable(variable, bytes, name, space);
}
void record_copied(const void* to, const void* from, size_t bytes, size_t alignment) {
    if (current_thread == nullptr) return;
    Machine::get().record_copied(Access::read, from, bytes, alignment);
    Machine::get().record_copied(Access::write, to, bytes, alignment);
}
void hear_accesses(bool heard) { current_thread->is_heard = heard; }
bool in_kernel() { return current_thread != nullptr; }
uint64_t clock_now() { return Machine::get().clock(); }
void give_way() {
    if (current_thread != nullptr) Machine::get().give_way();
}
void trap(const char* why, const void* place) {
    if (current_thread == nullptr) std::abort();
    Machine& machine = Machine::get();
    machine.end_thread(FindingKind::trap, why, machine.offset_in_text(place),
                       scotty::emulation::cuda::kLaunchFailure);
}
uint32_t lane_index() { return current_thread == nullptr ? 0 : current_thread->lane(); }

}  // namespace scotty_cuda
