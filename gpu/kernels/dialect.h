/// The kernel dialect: the few words that let one kernel text be CUDA and, elsewhere, coroutines.
///
/// Under nvcc every word is plain CUDA. Another executor (emulation/simt/) defines
/// SCOTTY_DIALECT_HEADER and gives the same words its own meaning; docs/kernel-dialect.md lists
/// them. Everything else in a kernel is ordinary C++ and the functions below, each named for what
/// it does on the device.
///
/// One program may hold several builds of the same text (exact and fast arithmetic, the executor),
/// so that all of gpu/ but its public headers lives in SCOTTY_DEVICE_NAMESPACE.
#pragma once

#include <cstdint>

#if defined(SCOTTY_DIALECT_HEADER)
#include SCOTTY_DIALECT_HEADER
#else

#if defined(SCOTTY_FAST_ARITHMETIC)
#define SCOTTY_DEVICE_NAMESPACE scotty::gpu::fast
#else
#define SCOTTY_DEVICE_NAMESPACE scotty::gpu::exact
#endif

/// A kernel; its parameter list follows.
#define SCOTTY_KERNEL(name) static __global__ void name
/// The same with registers for at most `threads` per block and at least `blocks` at once on a
/// multiprocessor.
#define SCOTTY_KERNEL_SIZED(threads, blocks, name) \
    static __global__ void __launch_bounds__(threads, blocks) name
/// A device function without barriers or collectives.
#define SCOTTY_DEVICE __device__ __forceinline__
/// A device function with barriers or collectives; call it through SCOTTY_AWAIT.
#define SCOTTY_COLLECTIVE(type) __device__ __forceinline__ type
/// A barrier for the whole block.
#define SCOTTY_SYNC() __syncthreads()
/// Runs a warp collective or a SCOTTY_COLLECTIVE function.
#define SCOTTY_AWAIT(call) (call)
/// return in a kernel or SCOTTY_COLLECTIVE function.
#define SCOTTY_RETURN return
/// Shared memory of the block.
#define SCOTTY_SHARED(type, name) __shared__ type name
/// Shared memory of the block, of the size that the launch gave: a pointer to its first element.
#define SCOTTY_SHARED_DYNAMIC(type, name)                                \
    extern __shared__ __align__(16) unsigned char scotty_shared_bytes[]; \
    type* const name = reinterpret_cast<type*>(scotty_shared_bytes)
/// Launches a kernel with the arguments that follow the stream.
#define SCOTTY_LAUNCH(kernel, blocks, threads, stream, ...) \
    SCOTTY_LAUNCH_SHARED(kernel, blocks, threads, 0, stream, __VA_ARGS__)
/// The same with bytes of shared memory for each block, for SCOTTY_SHARED_DYNAMIC.
#define SCOTTY_LAUNCH_SHARED(kernel, blocks, threads, bytes, stream, ...) \
    kernel<<<blocks, threads, bytes, stream>>>(__VA_ARGS__)

namespace SCOTTY_DEVICE_NAMESPACE {

/// Names a piece of device memory for reports, where a checker watches it.
inline void label_memory(const void* /*memory*/, const char* /*name*/) {}
/// The content is no longer needed; until the next call each place is written at most once.
inline void discard_slots(const void* /*memory*/, std::size_t /*bytes*/) {}

constexpr std::uint32_t kWarpSize = 32;
constexpr std::uint32_t kWholeWarp = 0xffffffffu;

SCOTTY_DEVICE std::uint32_t thread_index() { return threadIdx.x; }
SCOTTY_DEVICE std::uint32_t block_size() { return blockDim.x; }
SCOTTY_DEVICE std::uint32_t block_index() { return blockIdx.x; }
SCOTTY_DEVICE std::uint32_t grid_size() { return gridDim.x; }
SCOTTY_DEVICE std::uint32_t lane_index() { return threadIdx.x % kWarpSize; }
SCOTTY_DEVICE std::uint32_t warp_index() { return threadIdx.x / kWarpSize; }

// Collectives of the lanes that `mask` names; each of them passes the same mask and is in it.

/// Bit i: the predicate of lane i.
SCOTTY_DEVICE std::uint32_t warp_ballot(bool predicate, std::uint32_t mask = kWholeWarp) {
    return __ballot_sync(mask, predicate);
}
SCOTTY_DEVICE bool warp_any(bool predicate, std::uint32_t mask = kWholeWarp) {
    return __any_sync(mask, predicate) != 0;
}
SCOTTY_DEVICE bool warp_all(bool predicate, std::uint32_t mask = kWholeWarp) {
    return __all_sync(mask, predicate) != 0;
}
/// Bit i: lane i has the same value as the caller.
SCOTTY_DEVICE std::uint32_t warp_match(std::uint32_t value, std::uint32_t mask = kWholeWarp) {
    return __match_any_sync(mask, value);
}
/// The value of a lane of the mask.
SCOTTY_DEVICE std::uint32_t warp_shuffle(std::uint32_t value, std::uint32_t lane,
                                         std::uint32_t mask = kWholeWarp) {
    return __shfl_sync(mask, value, static_cast<int>(lane));
}
/// Takes a ballot for each of the `Count` lowest bits.
template <int Count>
struct Ballots {
    std::uint32_t of[Count];
};
template <int Count>
SCOTTY_DEVICE Ballots<Count> warp_ballots(std::uint32_t bits) {
    Ballots<Count> ballots;
#pragma unroll
    for (int i = 0; i < Count; ++i) ballots.of[i] = warp_ballot((bits >> i & 1u) != 0);
    return ballots;
}
/// The value that the lane `delta` below holds; without such a lane, the caller's own.
SCOTTY_DEVICE std::uint32_t warp_shuffle_up(std::uint32_t value, std::uint32_t delta) {
    return __shfl_up_sync(kWholeWarp, value, delta);
}
SCOTTY_DEVICE std::uint32_t count_bits(std::uint32_t bits) {
    return static_cast<std::uint32_t>(__popc(bits));
}
SCOTTY_DEVICE std::uint32_t bits_below_lane(std::uint32_t bits) {
    return bits & ((1u << lane_index()) - 1u);
}

SCOTTY_DEVICE std::uint32_t atomic_add(std::uint32_t* target, std::uint32_t value) {
    return atomicAdd(target, value);
}
SCOTTY_DEVICE void atomic_max(std::uint32_t* target, std::uint32_t value) {
    atomicMax(target, value);
}
SCOTTY_DEVICE void atomic_min(std::uint64_t* target, std::uint64_t value) {
    atomicMin(reinterpret_cast<unsigned long long*>(target),
              static_cast<unsigned long long>(value));
}
/// Distances are ordered by their bits as signed integers: this holds from +0 up, and the negative
/// "done" mark is below all of them.
SCOTTY_DEVICE void atomic_min_distance(float* target, float value) {
    atomicMin(reinterpret_cast<int*>(target), __float_as_int(value));
}
/// A read while others may write (early-out `immediate`): its value is never wrong, only late.
SCOTTY_DEVICE float load_relaxed(const float* source) {
    return *static_cast<const volatile float*>(source);
}
SCOTTY_DEVICE std::uint64_t load_relaxed(const std::uint64_t* source) {
    return *static_cast<const volatile std::uint64_t*>(source);
}
/// A write that others may read at the same time: they see the old or the new word, whole.
SCOTTY_DEVICE void store_relaxed(std::uint64_t* target, std::uint64_t value) {
    *static_cast<volatile std::uint64_t*>(target) = value;
}
SCOTTY_DEVICE std::uint32_t float_bits(float value) { return __float_as_uint(value); }
SCOTTY_DEVICE float bits_float(std::uint32_t bits) { return __uint_as_float(bits); }

/// The greatest of three by their bits as signed integers, in one instruction from Hopper on. It is
/// the greatest number too, unless all are negative.
SCOTTY_DEVICE float greatest_bits(float a, float b, float c) {
    return __int_as_float(__vimax3_s32(__float_as_int(a), __float_as_int(b), __float_as_int(c)));
}
SCOTTY_DEVICE float greatest_bits(float a, float b) {
    return __int_as_float(max(__float_as_int(a), __float_as_int(b)));
}
/// The least of three likewise: the least number too, or a negative one where any is negative.
SCOTTY_DEVICE float least_bits(float a, float b, float c) {
    return __int_as_float(__vimin3_s32(__float_as_int(a), __float_as_int(b), __float_as_int(c)));
}
SCOTTY_DEVICE float least_bits(float a, float b) {
    return __int_as_float(min(__float_as_int(a), __float_as_int(b)));
}

template <class Record, class Piece>
SCOTTY_DEVICE Record load_pieces(const Record* source) {
    union {
        Piece pieces[sizeof(Record) / sizeof(Piece)];
        Record record;
    } loaded;
    const auto* from = reinterpret_cast<const Piece*>(source);
#pragma unroll
    for (unsigned i = 0; i < sizeof(Record) / sizeof(Piece); ++i) {
        loaded.pieces[i] = __ldg(from + i);
    }
    return loaded.record;
}
/// Copies in pieces of 16, 8 or 4 bytes, to which records are aligned.
template <class Record>
SCOTTY_DEVICE Record load_record(const Record* source) {
    static_assert(sizeof(Record) % 4 == 0, "whole words");
    if constexpr (sizeof(Record) % 16 == 0) {
        return load_pieces<Record, float4>(source);
    } else if constexpr (sizeof(Record) % 8 == 0) {
        return load_pieces<Record, float2>(source);
    } else {
        return load_pieces<Record, float>(source);
    }
}
template <class Record>
SCOTTY_DEVICE void store_record(Record* target, const Record& value) {
    static_assert(sizeof(Record) == 16, "one 16-byte store");
    union {
        float4 piece;
        Record record;
    } stored;
    stored.record = value;
    *reinterpret_cast<float4*>(target) = stored.piece;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE

#endif
