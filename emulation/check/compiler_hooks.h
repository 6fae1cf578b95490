/// The calls that the compiler puts before loads and stores and in place of atomics under
/// -fsanitize=thread, defined for a program that is linked without the sanitizer's library.
///
/// To be included by one file of such a program, behind a struct `Hooks` of static inline functions
/// that say what becomes of an access: read, write, volatile_read, volatile_write (address, bytes,
/// place, aligned) and atomic, atomic_load (address, bytes, place). All memory orders become the
/// strongest. That file defines the few other calls itself.
#pragma once

#include <cstddef>
#include <cstdint>

// The names and the types are the compiler's.
// NOLINTBEGIN
#define SCOTTY_PLACE __builtin_return_address(0)
#define SCOTTY_PLAIN_CALL(name, kind, bytes, aligned) \
    void __tsan_##name##bytes(void* a) { Hooks::kind(a, bytes, SCOTTY_PLACE, aligned); }
#define SCOTTY_PLAIN(bytes)                                                 \
    SCOTTY_PLAIN_CALL(read, read, bytes, true)                              \
    SCOTTY_PLAIN_CALL(write, write, bytes, true)                            \
    SCOTTY_PLAIN_CALL(unaligned_read, read, bytes, false)                   \
    SCOTTY_PLAIN_CALL(unaligned_write, write, bytes, false)                 \
    SCOTTY_PLAIN_CALL(volatile_read, volatile_read, bytes, true)            \
    SCOTTY_PLAIN_CALL(volatile_write, volatile_write, bytes, true)          \
    SCOTTY_PLAIN_CALL(unaligned_volatile_read, volatile_read, bytes, false) \
    SCOTTY_PLAIN_CALL(unaligned_volatile_write, volatile_write, bytes, false)
#define SCOTTY_FETCH(bits, name)                                                            \
    std::uint##bits##_t __tsan_atomic##bits##_fetch_##name(volatile std::uint##bits##_t* a, \
                                                           std::uint##bits##_t v, int) {    \
        Hooks::atomic(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);         \
        return __atomic_fetch_##name(a, v, __ATOMIC_SEQ_CST);                               \
    }
#define SCOTTY_COMPARE(bits, strength, weak)                                                      \
    int __tsan_atomic##bits##_compare_exchange_##strength(volatile std::uint##bits##_t* a,        \
                                                          std::uint##bits##_t* expected,          \
                                                          std::uint##bits##_t v, int, int) {      \
        Hooks::atomic(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);               \
        return static_cast<int>(__atomic_compare_exchange_n(a, expected, v, weak,                 \
                                                            __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST)); \
    }
#define SCOTTY_ATOMIC(bits)                                                                      \
    std::uint##bits##_t __tsan_atomic##bits##_load(const volatile std::uint##bits##_t* a, int) { \
        Hooks::atomic_load(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);         \
        return __atomic_load_n(a, __ATOMIC_SEQ_CST);                                             \
    }                                                                                            \
    void __tsan_atomic##bits##_store(volatile std::uint##bits##_t* a, std::uint##bits##_t v,     \
                                     int) {                                                      \
        Hooks::atomic(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);              \
        __atomic_store_n(a, v, __ATOMIC_SEQ_CST);                                                \
    }                                                                                            \
    std::uint##bits##_t __tsan_atomic##bits##_exchange(volatile std::uint##bits##_t* a,          \
                                                       std::uint##bits##_t v, int) {             \
        Hooks::atomic(const_cast<std::uint##bits##_t*>(a), bits / 8, SCOTTY_PLACE);              \
        return __atomic_exchange_n(a, v, __ATOMIC_SEQ_CST);                                      \
    }                                                                                            \
    SCOTTY_FETCH(bits, add)                                                                      \
    SCOTTY_FETCH(bits, sub)                                                                      \
    SCOTTY_FETCH(bits, and)                                                                      \
    SCOTTY_FETCH(bits, or)                                                                       \
    SCOTTY_FETCH(bits, xor)                                                                      \
    SCOTTY_COMPARE(bits, strong, false)                                                          \
    SCOTTY_COMPARE(bits, weak, true)

extern "C" {
SCOTTY_PLAIN(1)
SCOTTY_PLAIN(2)
SCOTTY_PLAIN(4)
SCOTTY_PLAIN(8)
SCOTTY_PLAIN(16)
void __tsan_read_range(void* a, std::size_t n) { Hooks::read(a, n, SCOTTY_PLACE, false); }
void __tsan_write_range(void* a, std::size_t n) { Hooks::write(a, n, SCOTTY_PLACE, false); }
SCOTTY_ATOMIC(8)
SCOTTY_ATOMIC(16)
SCOTTY_ATOMIC(32)
SCOTTY_ATOMIC(64)
void __tsan_atomic_signal_fence(int) {}
void __tsan_init() {}
}
// NOLINTEND
