/// Atomics on global memory, named as CUDA names them; relaxed, as theirs are.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#if defined(SCOTTY_CHECKED)
#include "emulation/check/deliberate.h"
#endif

namespace scotty::emulation {

/// Returns the value before.
inline std::uint32_t atomic_add(std::uint32_t& target, std::uint32_t value) {
    return std::atomic_ref<std::uint32_t>(target).fetch_add(value, std::memory_order_relaxed);
}

inline void atomic_min(std::uint64_t& target, std::uint64_t value) {
    std::atomic_ref<std::uint64_t> reference(target);
    std::uint64_t current = reference.load(std::memory_order_relaxed);
    while (value < current &&
           !reference.compare_exchange_weak(current, value, std::memory_order_relaxed)) {
    }
}

inline void atomic_max(std::uint32_t& target, std::uint32_t value) {
    std::atomic_ref<std::uint32_t> reference(target);
    std::uint32_t current = reference.load(std::memory_order_relaxed);
    while (current < value &&
           !reference.compare_exchange_weak(current, value, std::memory_order_relaxed)) {
    }
}

/// Minimum of distances by their bits as signed integers (CUDA has no float atomicMin): right for
/// values >= +0 and for the negative "done" mark, which is below all of them.
inline void atomic_min_distance(float& target, float value) {
    std::atomic_ref<float> reference(target);
    float current = reference.load(std::memory_order_relaxed);
    while (std::bit_cast<std::int32_t>(value) < std::bit_cast<std::int32_t>(current) &&
           !reference.compare_exchange_weak(current, value, std::memory_order_relaxed)) {
    }
}

/// Asks for a value that the block needs soon. It hides the latency of a gather, as a device's
/// other warps do; it is a hint and no access.
template <class T>
void prefetch(const T* address) {
    __builtin_prefetch(address);
}

/// A read while others may write: the early-out's value is never wrong, only late.
template <class T>
T load_watched(const T& source) {
#if defined(SCOTTY_CHECKED)
    const simt::Deliberate here;
#endif
    return std::atomic_ref<T>(const_cast<T&>(source)).load(std::memory_order_relaxed);
}
inline float load_relaxed(const float& source) { return load_watched(source); }
inline std::uint64_t load_relaxed(const std::uint64_t& source) { return load_watched(source); }
inline void store_relaxed(std::uint64_t& target, std::uint64_t value) {
    std::atomic_ref<std::uint64_t>(target).store(value, std::memory_order_relaxed);
}

}  // namespace scotty::emulation
