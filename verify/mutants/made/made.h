/// Faults made by a machine: the switch that each of them stands behind. Every unit of the copy
/// that has them includes this first (-include); the project itself has no trace of it.
///
/// SCOTTY_MADE=n switches fault n on. SCOTTY_MADE_SEEN=FILE: byte n of the file becomes 1 when the
/// text of fault n is executed (and only that fault's, where one is on); it is a mapping, so a
/// process that crashes leaves it too.
#pragma once
#if __cplusplus >= 202002L  // CMake tries the compiler without any standard

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>

namespace scotty::made {

constexpr int kMost = 1 << 17;
enum : unsigned char { kOff = 0, kOn = 1, kToBeSeen = 2 };

struct Switches {
    unsigned char state[kMost] = {};
    unsigned char* seen = nullptr;

    Switches() {
        if (const char* path = std::getenv("SCOTTY_MADE_SEEN")) {
            const int file = ::open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
            if (file < 0 || ::ftruncate(file, kMost) != 0) std::abort();
            void* mapped = ::mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
            if (mapped == MAP_FAILED) std::abort();
            ::close(file);
            seen = static_cast<unsigned char*>(mapped);
        }
        const char* number = std::getenv("SCOTTY_MADE");
        if (number != nullptr) {
            state[std::atoi(number) % kMost] = kOn;
        } else if (seen != nullptr) {
            std::memset(state, kToBeSeen, sizeof state);
        }
    }
};
inline Switches switches;

// Not inlined, and not watched by the checker of loads and stores, whose calls are the thread
// sanitizer's.
__attribute__((noinline, cold, no_sanitize("thread"))) inline bool slow(int number) {
    if (switches.seen != nullptr) switches.seen[number] = 1;
    if (switches.state[number] == kOn) return true;
    switches.state[number] = kOff;
    return false;
}

#ifdef __SANITIZE_THREAD__
__attribute__((noinline, no_sanitize("thread"))) inline bool watched_on(int number) {
    return switches.state[number] != kOff && slow(number);
}
#endif

/// Constant expressions have no faults.
[[gnu::always_inline]] constexpr bool on(int number) {
    if (std::is_constant_evaluated()) return false;
#ifdef __SANITIZE_THREAD__
    return watched_on(number);
#else
    return __builtin_expect(switches.state[number], kOff) != kOff && slow(number);
#endif
}

template <class T>
T one_ulp_up(T value) {
    return std::nextafter(value, std::numeric_limits<T>::infinity());
}

/// The lower half of the bits.
template <class T>
T half_as_wide(T value) {
    if constexpr (sizeof(T) == 8) return static_cast<T>(static_cast<std::uint32_t>(value));
    if constexpr (sizeof(T) == 4) return static_cast<T>(static_cast<std::uint16_t>(value));
    return static_cast<T>(static_cast<std::uint8_t>(value));
}

/// What a variable holds that nobody initialised.
template <class T>
T unwritten(T value) {
    if constexpr (std::is_same_v<T, bool>)
        return !value;
    else {
        std::memset(&value, 0xa5, sizeof value);
        return value;
    }
}

template <class T>
T& target_of(T& target) {
    return target;
}
template <class T>
T& target_of(T* target) {
    return *target;
}

template <class T, class V>
[[gnu::always_inline]] inline auto plain_atomic_add(T&& target, V value) {
    auto& at = target_of(target);
    const auto before = at;
    at = before + static_cast<std::remove_cvref_t<decltype(at)>>(value);
    return before;
}
template <class T, class V>
[[gnu::always_inline]] inline void plain_atomic_max(T&& target, V value) {
    auto& at = target_of(target);
    if (at < value) at = value;
}
template <class T, class V>
[[gnu::always_inline]] inline void plain_atomic_min(T&& target, V value) {
    auto& at = target_of(target);
    if (value < at) at = value;
}
template <class T, class V>
[[gnu::always_inline]] inline void plain_atomic_min_distance(T&& target, V value) {
    plain_atomic_min(target, value);
}

}  // namespace scotty::made

#define MADE(number) (::scotty::made::on(number))

#endif
