/// The kernel dialect's words as the SIMT executor runs them: see gpu/kernels/dialect.h, which
/// includes this file where SCOTTY_DIALECT_HEADER names it.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "emulation/device/atomics.h"
#include "emulation/execution/context.h"
#include "emulation/simt/collectives.h"
#include "emulation/simt/current_device.h"
#include "emulation/simt/late_stores.h"
#include "emulation/simt/task.h"

#define SCOTTY_DEVICE_NAMESPACE scotty::gpu::simt

#define SCOTTY_KERNEL(name) inline ::scotty::emulation::simt::Kernel name
#define SCOTTY_KERNEL_SIZED(threads, blocks, name) SCOTTY_KERNEL(name)
#define SCOTTY_DEVICE inline
#define SCOTTY_COLLECTIVE(type) inline ::scotty::emulation::simt::Task<type>
#define SCOTTY_SYNC() (co_await ::scotty::emulation::simt::Barrier(SCOTTY_SITE(barrier)))
#define SCOTTY_AWAIT(call) (co_await ::scotty::emulation::simt::at(SCOTTY_SITE(collective), call))
/// This is a loop, so that it is one statement with or without a return value, and not half an if.
#define SCOTTY_RETURN \
    for (::scotty::emulation::simt::leave(SCOTTY_SITE(exit));;) co_return
#define SCOTTY_SHARED(type, name)                                                       \
    type& name = *static_cast<type*>(::scotty::emulation::simt::context.shared->object( \
        &SCOTTY_SITE(exit), #name, sizeof(type), alignof(type)))
#define SCOTTY_SHARED_DYNAMIC(type, name) \
    type* const name = static_cast<type*>(::scotty::emulation::simt::context.shared->dynamic())
#define SCOTTY_LAUNCH(kernel, blocks, threads, stream, ...) \
    SCOTTY_LAUNCH_SHARED(kernel, blocks, threads, 0, stream __VA_OPT__(, ) __VA_ARGS__)
#define SCOTTY_LAUNCH_SHARED(kernel, blocks, threads, bytes, stream, ...)         \
    ::scotty::emulation::simt::launch_on_current_device(                          \
        #kernel, ::scotty::emulation::simt::Grid{blocks, threads, bytes}, stream, \
        kernel __VA_OPT__(, ) __VA_ARGS__)

namespace SCOTTY_DEVICE_NAMESPACE {

constexpr std::uint32_t kWarpSize = emulation::simt::kLanes;
constexpr std::uint32_t kWholeWarp = 0xffffffffu;

inline void label_memory(const void* memory, const char* name) {
    emulation::simt::label_on_current_device(memory, name);
}
inline void discard_slots(const void* memory, std::size_t bytes) {
    emulation::simt::discard_on_current_device(memory, bytes);
}

SCOTTY_DEVICE std::uint32_t thread_index() { return emulation::simt::context.thread; }
SCOTTY_DEVICE std::uint32_t block_size() { return emulation::simt::context.block_size; }
SCOTTY_DEVICE std::uint32_t block_index() { return emulation::simt::context.block; }
SCOTTY_DEVICE std::uint32_t grid_size() { return emulation::simt::context.grid_size; }
SCOTTY_DEVICE std::uint32_t lane_index() { return thread_index() % kWarpSize; }
SCOTTY_DEVICE std::uint32_t warp_index() { return thread_index() / kWarpSize; }

SCOTTY_DEVICE emulation::simt::WarpBallot warp_ballot(bool predicate) {
    return emulation::simt::WarpBallot(predicate);
}
SCOTTY_DEVICE emulation::simt::MaskedBallot warp_ballot(bool predicate, std::uint32_t mask) {
    return {predicate, mask};
}
SCOTTY_DEVICE emulation::simt::WarpAny warp_any(bool predicate, std::uint32_t mask = kWholeWarp) {
    return {predicate, mask};
}
SCOTTY_DEVICE emulation::simt::WarpAll warp_all(bool predicate, std::uint32_t mask = kWholeWarp) {
    return {predicate, mask};
}
SCOTTY_DEVICE emulation::simt::WarpMatch warp_match(std::uint32_t value,
                                                    std::uint32_t mask = kWholeWarp) {
    return {value, mask};
}
SCOTTY_DEVICE emulation::simt::WarpShuffle warp_shuffle(std::uint32_t value, std::uint32_t lane,
                                                        std::uint32_t mask = kWholeWarp) {
    return {value, lane, mask};
}
template <int Count>
SCOTTY_DEVICE emulation::simt::WarpBallots<Count> warp_ballots(std::uint32_t bits) {
    return emulation::simt::WarpBallots<Count>(bits);
}
SCOTTY_DEVICE emulation::simt::WarpShuffleUp warp_shuffle_up(std::uint32_t value,
                                                             std::uint32_t delta) {
    return {value, delta};
}
SCOTTY_DEVICE std::uint32_t count_bits(std::uint32_t bits) {
    return static_cast<std::uint32_t>(std::popcount(bits));
}
SCOTTY_DEVICE std::uint32_t bits_below_lane(std::uint32_t bits) {
    return bits & ((1u << lane_index()) - 1u);
}

SCOTTY_DEVICE std::uint32_t atomic_add(std::uint32_t* target, std::uint32_t value) {
    return emulation::atomic_add(*target, value);
}
SCOTTY_DEVICE void atomic_max(std::uint32_t* target, std::uint32_t value) {
    emulation::atomic_max(*target, value);
}
SCOTTY_DEVICE void atomic_min(std::uint64_t* target, std::uint64_t value) {
    emulation::atomic_min(*target, value);
}
SCOTTY_DEVICE void atomic_min_distance(float* target, float value) {
    emulation::atomic_min_distance(*target, value);
}
SCOTTY_DEVICE float load_relaxed(const float* source) { return emulation::load_relaxed(*source); }
SCOTTY_DEVICE std::uint64_t load_relaxed(const std::uint64_t* source) {
    const std::uint64_t now = emulation::load_relaxed(*source);
    emulation::simt::LateStores* late = emulation::simt::context.late_stores;
    return late == nullptr ? now : late->loaded(source, now);
}
SCOTTY_DEVICE void store_relaxed(std::uint64_t* target, std::uint64_t value) {
    emulation::simt::LateStores* late = emulation::simt::context.late_stores;
    if (late != nullptr) late->stored(target, emulation::load_relaxed(*target));
    emulation::store_relaxed(*target, value);
}
SCOTTY_DEVICE std::uint32_t float_bits(float value) { return std::bit_cast<std::uint32_t>(value); }
SCOTTY_DEVICE float bits_float(std::uint32_t bits) { return std::bit_cast<float>(bits); }

SCOTTY_DEVICE float greatest_bits(float a, float b) {
    return std::bit_cast<std::int32_t>(a) > std::bit_cast<std::int32_t>(b) ? a : b;
}
SCOTTY_DEVICE float greatest_bits(float a, float b, float c) {
    return greatest_bits(greatest_bits(a, b), c);
}
SCOTTY_DEVICE float least_bits(float a, float b) {
    return std::bit_cast<std::int32_t>(a) < std::bit_cast<std::int32_t>(b) ? a : b;
}
SCOTTY_DEVICE float least_bits(float a, float b, float c) {
    return least_bits(least_bits(a, b), c);
}

template <class Record>
SCOTTY_DEVICE Record load_record(const Record* source) {
    static_assert(sizeof(Record) % 4 == 0, "whole words");
    return *source;
}
template <class Record>
SCOTTY_DEVICE void store_record(Record* target, const Record& value) {
    *target = value;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
