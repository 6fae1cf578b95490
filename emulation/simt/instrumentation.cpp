/// The functions that the compiler calls before every access of checked code
/// (emulation/check/compiler_hooks.h): with the running CUDA thread known, they say which thread
/// touches what. Only programs that check contain this file.
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "emulation/check/deliberate.h"
#include "emulation/check/memory_checker.h"
#include "emulation/execution/context.h"
#include "emulation/simt/interleave/interleaver.h"

namespace {

using scotty::emulation::simt::Access;
using scotty::emulation::simt::context;
using scotty::emulation::simt::deliberate_read;

template <Access access>
inline void note(const void* address, std::size_t bytes, const void* place) {
    auto& now = context;
    now.last_access = place;
    if (now.checker == nullptr) {
        if (now.interleaver != nullptr) now.interleaver->on_access(access, address, bytes);
        if (now.on_registers != nullptr)
            now.on_registers->report_memory(access, address, place, now);
        return;
    }
    now.checker->on_access<access>(address, bytes, place, now);
}

struct Hooks {
    static void read(const void* a, std::size_t bytes, const void* place, bool) {
        note<Access::read>(a, bytes, place);
    }
    static void write(const void* a, std::size_t bytes, const void* place, bool) {
        note<Access::write>(a, bytes, place);
    }
    static void volatile_read(const void* a, std::size_t bytes, const void* place, bool) {
        note<Access::relaxed_read>(a, bytes, place);
    }
    static void volatile_write(const void* a, std::size_t bytes, const void* place, bool) {
        note<Access::write>(a, bytes, place);
    }
    static void atomic(const void* a, std::size_t bytes, const void* place) {
        note<Access::atomic>(a, bytes, place);
    }
    /// A load is the first part of an atomic, unless it is load_relaxed().
    static void atomic_load(const void* a, std::size_t bytes, const void* place) {
        (deliberate_read ? note<Access::relaxed_read> : note<Access::atomic>)(a, bytes, place);
    }
};

}  // namespace

#include "emulation/check/compiler_hooks.h"

// NOLINTBEGIN
extern "C" {
// heard_copies.h. Of a move, the reads come before the writes as in a copy.
void* scotty_heard_memcpy(void* to, const void* from, std::size_t bytes) noexcept {
    if (bytes != 0) note<Access::read>(from, bytes, SCOTTY_PLACE);
    if (bytes != 0) note<Access::write>(to, bytes, SCOTTY_PLACE);
    return std::memcpy(to, from, bytes);
}
void* scotty_heard_memmove(void* to, const void* from, std::size_t bytes) noexcept {
    if (bytes != 0) note<Access::read>(from, bytes, SCOTTY_PLACE);
    if (bytes != 0) note<Access::write>(to, bytes, SCOTTY_PLACE);
    return std::memmove(to, from, bytes);
}
void* scotty_heard_memset(void* to, int value, std::size_t bytes) noexcept {
    if (bytes != 0) note<Access::write>(to, bytes, SCOTTY_PLACE);
    return std::memset(to, value, bytes);
}
void __tsan_atomic_thread_fence(int) { __atomic_thread_fence(__ATOMIC_SEQ_CST); }
void __tsan_func_entry(void*) {}
void __tsan_func_exit() {}
void __tsan_vptr_update(void**, void*) {}
void __tsan_vptr_read(void**) {}
}
// NOLINTEND
