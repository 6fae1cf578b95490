/// Barriers, fences and warp collectives, named as CUDA names them.
// NOLINTBEGIN
#pragma once

#include <string.h>

#include "interface.h"
#include "launch.h"

#define SCOTTY_HERE __builtin_return_address(0)
#define SCOTTY_CALL __attribute__((no_sanitize_thread, noinline)) inline

SCOTTY_CALL void __syncthreads() {
    scotty_cuda::barrier(scotty_cuda::Barrier::plain, 0, SCOTTY_HERE);
}
SCOTTY_CALL int __syncthreads_and(int predicate) {
    return scotty_cuda::barrier(scotty_cuda::Barrier::all, predicate, SCOTTY_HERE);
}
SCOTTY_CALL int __syncthreads_or(int predicate) {
    return scotty_cuda::barrier(scotty_cuda::Barrier::any, predicate, SCOTTY_HERE);
}
SCOTTY_CALL int __syncthreads_count(int predicate) {
    return scotty_cuda::barrier(scotty_cuda::Barrier::count, predicate, SCOTTY_HERE);
}
SCOTTY_CALL void __syncwarp(unsigned mask = 0xffffffffu) {
    scotty_cuda::warp(scotty_cuda::WarpOperation::sync, mask, 0, 0, 32, nullptr, SCOTTY_HERE);
}
SCOTTY_CALL void __threadfence_block() {
    scotty_cuda::fence(scotty_cuda::Scope::block, scotty_cuda::Order::acquire_release);
}
SCOTTY_CALL void __threadfence() {
    scotty_cuda::fence(scotty_cuda::Scope::device, scotty_cuda::Order::acquire_release);
}
SCOTTY_CALL void __threadfence_system() {
    scotty_cuda::fence(scotty_cuda::Scope::system, scotty_cuda::Order::acquire_release);
}

SCOTTY_CALL int __any_sync(unsigned mask, int predicate) {
    return static_cast<int>(scotty_cuda::warp(scotty_cuda::WarpOperation::any, mask, predicate != 0,
                                              0, 32, nullptr, SCOTTY_HERE));
}
SCOTTY_CALL int __all_sync(unsigned mask, int predicate) {
    return static_cast<int>(scotty_cuda::warp(scotty_cuda::WarpOperation::all, mask, predicate != 0,
                                              0, 32, nullptr, SCOTTY_HERE));
}
SCOTTY_CALL unsigned __ballot_sync(unsigned mask, int predicate) {
    return static_cast<unsigned>(scotty_cuda::warp(scotty_cuda::WarpOperation::ballot, mask,
                                                   predicate != 0, 0, 32, nullptr, SCOTTY_HERE));
}
SCOTTY_CALL unsigned __activemask() {
    return static_cast<unsigned>(
        scotty_cuda::warp(scotty_cuda::WarpOperation::active, 0, 0, 0, 32, nullptr, SCOTTY_HERE));
}

namespace scotty_cuda {
template <class T>
SCOTTY_UNSEEN uint64_t bits_of(const T& value) {
    static_assert(sizeof(T) <= 8, "a warp collective takes a value of at most 8 bytes");
    uint64_t bits = 0;
    __builtin_memcpy(&bits, &value, sizeof value);
    return bits;
}
template <class T>
SCOTTY_UNSEEN T value_of(uint64_t bits) {
    T value;
    __builtin_memcpy(&value, &bits, sizeof value);
    return value;
}
}  // namespace scotty_cuda

#define SCOTTY_SHUFFLE(name, operation, type)                                                \
    template <class T>                                                                       \
    SCOTTY_CALL T name(unsigned mask, T value, type parameter, int width = 32) {             \
        return scotty_cuda::value_of<T>(                                                     \
            scotty_cuda::warp(scotty_cuda::WarpOperation::operation, mask,                   \
                              scotty_cuda::bits_of(value), static_cast<unsigned>(parameter), \
                              static_cast<unsigned>(width), nullptr, SCOTTY_HERE));          \
    }
SCOTTY_SHUFFLE(__shfl_sync, shuffle, int)
SCOTTY_SHUFFLE(__shfl_up_sync, shuffle_up, unsigned)
SCOTTY_SHUFFLE(__shfl_down_sync, shuffle_down, unsigned)
SCOTTY_SHUFFLE(__shfl_xor_sync, shuffle_xor, int)
#undef SCOTTY_SHUFFLE

template <class T>
SCOTTY_CALL unsigned __match_any_sync(unsigned mask, T value) {
    return static_cast<unsigned>(scotty_cuda::warp(scotty_cuda::WarpOperation::match_any, mask,
                                                   scotty_cuda::bits_of(value), 0, 32, nullptr,
                                                   SCOTTY_HERE));
}
template <class T>
SCOTTY_CALL unsigned __match_all_sync(unsigned mask, T value, int* pred) {
    int flag = 0;
    const auto result = static_cast<unsigned>(
        scotty_cuda::warp(scotty_cuda::WarpOperation::match_all, mask, scotty_cuda::bits_of(value),
                          0, 32, &flag, SCOTTY_HERE));
    *pred = flag;
    return result;
}

#define SCOTTY_REDUCE(name, T, operation)                                                      \
    SCOTTY_CALL T name(unsigned mask, T value) {                                               \
        return static_cast<T>(scotty_cuda::warp(                                               \
            scotty_cuda::WarpOperation::operation, mask,                                       \
            static_cast<uint64_t>(static_cast<int64_t>(value)), 0, 32, nullptr, SCOTTY_HERE)); \
    }
SCOTTY_REDUCE(__reduce_add_sync, int, add)
SCOTTY_REDUCE(__reduce_add_sync, unsigned, add)
SCOTTY_REDUCE(__reduce_min_sync, int, min_signed)
SCOTTY_REDUCE(__reduce_min_sync, unsigned, min_unsigned)
SCOTTY_REDUCE(__reduce_max_sync, int, max_signed)
SCOTTY_REDUCE(__reduce_max_sync, unsigned, max_unsigned)
SCOTTY_REDUCE(__reduce_and_sync, unsigned, bit_and)
SCOTTY_REDUCE(__reduce_or_sync, unsigned, bit_or)
SCOTTY_REDUCE(__reduce_xor_sync, unsigned, bit_xor)
#undef SCOTTY_REDUCE

inline void __nanosleep(unsigned) { scotty_cuda::give_way(); }
inline long long clock64() { return static_cast<long long>(scotty_cuda::clock_now()); }
inline unsigned long long __globaltimer() { return scotty_cuda::clock_now(); }
[[noreturn]] SCOTTY_CALL void __trap() { scotty_cuda::trap("__trap()", SCOTTY_HERE); }
inline void __brkpt() {}
inline int __vimax3_s32(int a, int b, int c) { return a; }
inline int __vimin3_s32(int a, int b, int c) { return a; }
// NOLINTEND
