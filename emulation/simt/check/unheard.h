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

inline void store_unheard(std::uint32_t& to, std::uint32_t value) {
#if defined(__x86_64__)
    asm("movl %1, %0" : "=m"(to) : "r"(value));
#else
    to = value;
#endif
}

}  // namespace scotty::emulation::simt
