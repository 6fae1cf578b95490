/// The few CUDA declarations that the kernels use, for a compiler that knows CUDA where there is no
/// toolkit: enough to see which instructions the kernels become, not to run them.
#pragma once

#define __global__ __attribute__((global))
#define __device__ __attribute__((device))
#define __host__ __attribute__((host))
#define __shared__ __attribute__((shared))
#define __constant__ __attribute__((constant))
#define __forceinline__ inline __attribute__((always_inline))
#define __launch_bounds__(...) __attribute__((launch_bounds(__VA_ARGS__)))

#define CUDART_VERSION 12000

#include <cmath>
#include <cstdlib>
#include <cstring>

#include <__clang_cuda_builtin_vars.h>

struct alignas(8) float2 {
    float x, y;
};
struct alignas(16) float4 {
    float x, y, z, w;
};

__device__ inline unsigned __ballot_sync(unsigned mask, bool predicate) {
    return __nvvm_vote_ballot_sync(mask, predicate);
}
__device__ inline int __any_sync(unsigned mask, bool predicate) {
    return __nvvm_vote_any_sync(mask, predicate);
}
__device__ inline int __all_sync(unsigned mask, bool predicate) {
    return __nvvm_vote_all_sync(mask, predicate);
}
__device__ inline unsigned __match_any_sync(unsigned mask, unsigned value) {
    return __nvvm_match_any_sync_i32(mask, value);
}
__device__ inline unsigned __shfl_sync(unsigned mask, unsigned value, int lane) {
    return static_cast<unsigned>(
        __nvvm_shfl_sync_idx_i32(mask, static_cast<int>(value), lane, 0x1f));
}
__device__ inline unsigned __shfl_up_sync(unsigned mask, unsigned value, unsigned delta) {
    return static_cast<unsigned>(
        __nvvm_shfl_sync_up_i32(mask, static_cast<int>(value), static_cast<int>(delta), 0));
}
__device__ inline int __popc(unsigned bits) { return __builtin_popcount(bits); }
__device__ inline unsigned __umulhi(unsigned a, unsigned b) {
    return static_cast<unsigned>((static_cast<unsigned long long>(a) * b) >> 32);
}
__device__ inline unsigned atomicAdd(unsigned* target, unsigned value) {
    return __atomic_fetch_add(target, value, __ATOMIC_RELAXED);
}
__device__ inline unsigned atomicMax(unsigned* target, unsigned value) {
    return __nvvm_atom_max_gen_ui(target, value);
}
__device__ inline int atomicMin(int* target, int value) {
    return __nvvm_atom_min_gen_i(target, value);
}
__device__ inline unsigned long long atomicMin(unsigned long long* target,
                                               unsigned long long value) {
    return __nvvm_atom_min_gen_ull(target, value);
}
__device__ inline unsigned __float_as_uint(float value) {
    return __builtin_bit_cast(unsigned, value);
}
__device__ inline int __float_as_int(float value) { return __builtin_bit_cast(int, value); }
__device__ inline float __uint_as_float(unsigned bits) { return __builtin_bit_cast(float, bits); }
__device__ inline float __int_as_float(int bits) { return __builtin_bit_cast(float, bits); }
__device__ inline int max(int a, int b) { return a > b ? a : b; }
__device__ inline int min(int a, int b) { return a < b ? a : b; }
__device__ inline int __vimax3_s32(int a, int b, int c) { return max(max(a, b), c); }
__device__ inline int __vimin3_s32(int a, int b, int c) { return min(min(a, b), c); }
__device__ inline float __ldg(const float* source) { return *source; }
__device__ inline float2 __ldg(const float2* source) { return *source; }
__device__ inline float4 __ldg(const float4* source) { return *source; }
__device__ inline unsigned long long __umul64hi(unsigned long long a, unsigned long long b) {
    return static_cast<unsigned long long>((static_cast<unsigned __int128>(a) * b) >> 64);
}
__device__ inline float fabsf(float value) { return __builtin_fabsf(value); }
__device__ inline float fminf(float a, float b) { return __nvvm_fmin_f(a, b); }
__device__ inline float fmaxf(float a, float b) { return __nvvm_fmax_f(a, b); }
__device__ inline float sqrtf(float value) { return __builtin_sqrtf(value); }
__device__ inline void* memcpy(void* to, const void* from, unsigned long bytes) {
    return __builtin_memcpy(to, from, bytes);
}
