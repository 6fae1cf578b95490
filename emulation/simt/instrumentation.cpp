/// The functions that the compiler calls before every access of code built with -fsanitize=thread.
///
/// That option makes g++ and clang put a call in front of each load and store and replace atomics
/// by calls. Linked without the option, the calls come here and not to the thread sanitizer's
/// library: with the running CUDA thread known, they say which thread touches what. Only programs
/// that check contain this file.
#include <cstddef>
#include <cstdint>

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

}  // namespace

// The names and the types are the compiler's.
// NOLINTBEGIN
#define SCOTTY_PLACE __builtin_return_address(0)
#define SCOTTY_PLAIN(bytes)                                                                      \
    void __tsan_read##bytes(void* a) { note<Access::read>(a, bytes, SCOTTY_PLACE); }             \
    void __tsan_write##bytes(void* a) { note<Access::write>(a, bytes, SCOTTY_PLACE); }           \
    void __tsan_unaligned_read##bytes(void* a) { note<Access::read>(a, bytes, SCOTTY_PLACE); }   \
    void __tsan_unaligned_write##bytes(void* a) { note<Access::write>(a, bytes, SCOTTY_PLACE); } \
    void __tsan_volatile_read##bytes(void* a) {                                                  \
        note<Access::relaxed_read>(a, bytes, SCOTTY_PLACE);                                      \
    }                                                                                            \
    void __tsan_volatile_write##bytes(void* a) { note<Access::write>(a, bytes, SCOTTY_PLACE); }

// All memory orders become the strongest; the kernels' own are relaxed. A load is the first part of
// an atomic, unless it is load_relaxed().
#define SCOTTY_FETCH(bits, name)                                                            \
    std::uint##bits##_t __tsan_atomic##bits##_fetch_##name(volatile std::uint##bits##_t* a, \
                                                           std::uint##bits##_t v, int) {    \
        note<Access::atomic>(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);  \
        return __atomic_fetch_##name(a, v, __ATOMIC_SEQ_CST);                               \
    }
#define SCOTTY_COMPARE(bits, strength, weak)                                                      \
    int __tsan_atomic##bits##_compare_exchange_##strength(volatile std::uint##bits##_t* a,        \
                                                          std::uint##bits##_t* expected,          \
                                                          std::uint##bits##_t v, int, int) {      \
        note<Access::atomic>(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);        \
        return static_cast<int>(__atomic_compare_exchange_n(a, expected, v, weak,                 \
                                                            __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST)); \
    }
#define SCOTTY_ATOMIC(bits)                                                                        \
    std::uint##bits##_t __tsan_atomic##bits##_load(const volatile std::uint##bits##_t* a, int) {   \
        (deliberate_read                                                                           \
             ? note<Access::relaxed_read>                                                          \
             : note<Access::atomic>)(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE); \
        return __atomic_load_n(a, __ATOMIC_SEQ_CST);                                               \
    }                                                                                              \
    void __tsan_atomic##bits##_store(volatile std::uint##bits##_t* a, std::uint##bits##_t v,       \
                                     int) {                                                        \
        note<Access::atomic>(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);         \
        __atomic_store_n(a, v, __ATOMIC_SEQ_CST);                                                  \
    }                                                                                              \
    std::uint##bits##_t __tsan_atomic##bits##_exchange(volatile std::uint##bits##_t* a,            \
                                                       std::uint##bits##_t v, int) {               \
        note<Access::atomic>(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);         \
        return __atomic_exchange_n(a, v, __ATOMIC_SEQ_CST);                                        \
    }                                                                                              \
    SCOTTY_FETCH(bits, add)                                                                        \
    SCOTTY_FETCH(bits, sub)                                                                        \
    SCOTTY_FETCH(bits, and)                                                                        \
    SCOTTY_FETCH(bits, or)                                                                         \
    SCOTTY_FETCH(bits, xor)                                                                        \
    SCOTTY_COMPARE(bits, strong, false)                                                            \
    SCOTTY_COMPARE(bits, weak, true)

extern "C" {
SCOTTY_PLAIN(1)
SCOTTY_PLAIN(2)
SCOTTY_PLAIN(4)
SCOTTY_PLAIN(8)
SCOTTY_PLAIN(16)
void __tsan_read_range(void* a, std::size_t bytes) { note<Access::read>(a, bytes, SCOTTY_PLACE); }
void __tsan_write_range(void* a, std::size_t bytes) { note<Access::write>(a, bytes, SCOTTY_PLACE); }
SCOTTY_ATOMIC(8)
SCOTTY_ATOMIC(16)
SCOTTY_ATOMIC(32)
SCOTTY_ATOMIC(64)
void __tsan_atomic_thread_fence(int) { __atomic_thread_fence(__ATOMIC_SEQ_CST); }
void __tsan_atomic_signal_fence(int) {}
void __tsan_func_entry(void*) {}
void __tsan_func_exit() {}
void __tsan_vptr_update(void**, void*) {}
void __tsan_vptr_read(void**) {}
void __tsan_init() {}
}
// NOLINTEND
