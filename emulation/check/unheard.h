/// Of the checker's own state, in code that is instrumented: the compiler puts its calls in front
/// of loads and stores that are written in C++, and not of these. With calls, who runs would be
/// more to tell than what runs.
#pragma once

#include <cstdint>

namespace scotty::emulation::simt {

inline std::uint32_t load_unheard(const std::uint32_t& from) {
#if defined(__x86_64__)
    std::uint32_t value;
    asm("movl %1, %0" : "=r"(value) : "m"(from));
    return value;
#else
    return from;  // as right, and slower
#endif
}

/// What stands before it stays before it, and what stands behind it behind.
inline void store_unheard(std::uint32_t& to, std::uint32_t value) {
#if defined(__x86_64__)
    asm volatile("movl %1, %0" : "=m"(to) : "r"(value) : "memory");
#else
    to = value;
    asm volatile("" ::: "memory");
#endif
}

}  // namespace scotty::emulation::simt
