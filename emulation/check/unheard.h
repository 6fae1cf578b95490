/// Loads and stores of the checker's own state in instrumented code: the compiler puts its calls in
/// front of loads and stores written in C++, and not of these. With calls, announcing which thread
/// runs would cost more than running it.
#pragma once

#include <cstdint>

namespace scotty::emulation::simt {

inline std::uint32_t load_unheard(const std::uint32_t& from) {
#if defined(__x86_64__)
    std::uint32_t value;
    asm("movl %1, %0" : "=r"(value) : "m"(from));
    return value;
#else
    return from;  // right too, and slower
#endif
}

/// The compiler moves no access across this store, in either direction.
inline void store_unheard(std::uint32_t& to, std::uint32_t value) {
#if defined(__x86_64__)
    asm volatile("movl %1, %0" : "=m"(to) : "r"(value) : "memory");
#else
    to = value;
    asm volatile("" ::: "memory");
#endif
}

}  // namespace scotty::emulation::simt
