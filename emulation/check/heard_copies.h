/// Copies and fills of memory in checked code. The compiler announces loads, stores and copies of
/// records, but not what memcpy(), memmove() and memset() do, nor std::copy() and others that call
/// them: they become calls that announce it (emulation/simt/instrumentation.cpp).
///
/// The compiler is told to include this before all else in checked code. Up to eight bytes it makes
/// a load and a store of a memcpy() anyway, and announces those.
#pragma once

#include <stddef.h>

// The names and the types are the C library's.
// NOLINTBEGIN
extern "C" {
void* scotty_heard_memcpy(void* to, const void* from, size_t bytes) noexcept;
void* scotty_heard_memmove(void* to, const void* from, size_t bytes) noexcept;
void* scotty_heard_memset(void* to, int value, size_t bytes) noexcept;

// What the compiler itself makes of other functions and of loops goes by these names, too.
void* memcpy(void* to, const void* from, size_t bytes) noexcept __asm__("scotty_heard_memcpy");
void* memmove(void* to, const void* from, size_t bytes) noexcept __asm__("scotty_heard_memmove");
void* memset(void* to, int value, size_t bytes) noexcept __asm__("scotty_heard_memset");

// It expands copies and fills of a few words in place, and then nothing is announced.
extern inline __attribute__((gnu_inline, always_inline, artificial)) void* memcpy(
    void* to, const void* from, size_t bytes) noexcept {
    if (__builtin_constant_p(bytes) && bytes <= 8) return __builtin_memcpy(to, from, bytes);
    return scotty_heard_memcpy(to, from, bytes);
}
extern inline __attribute__((gnu_inline, always_inline, artificial)) void* memset(
    void* to, int value, size_t bytes) noexcept {
    return scotty_heard_memset(to, value, bytes);
}
}
// NOLINTEND
