/// CUDA's functions on numbers: min and max of all types, bits, conversions, fast arithmetic (which
/// is exact here), cached loads.
// NOLINTBEGIN
#pragma once

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define SCOTTY_MIN_MAX(T)                                   \
    static inline T min(T a, T b) { return b < a ? b : a; } \
    static inline T max(T a, T b) { return a < b ? b : a; }
SCOTTY_MIN_MAX(int)
SCOTTY_MIN_MAX(unsigned int)
SCOTTY_MIN_MAX(long)
SCOTTY_MIN_MAX(unsigned long)
SCOTTY_MIN_MAX(long long)
SCOTTY_MIN_MAX(unsigned long long)
#undef SCOTTY_MIN_MAX
static inline float min(float a, float b) { return fminf(a, b); }
static inline float max(float a, float b) { return fmaxf(a, b); }
static inline double min(double a, double b) { return fmin(a, b); }
static inline double max(double a, double b) { return fmax(a, b); }
static inline unsigned min(unsigned a, int b) { return min(a, static_cast<unsigned>(b)); }
static inline unsigned min(int a, unsigned b) { return min(static_cast<unsigned>(a), b); }
static inline unsigned max(unsigned a, int b) { return max(a, static_cast<unsigned>(b)); }
static inline unsigned max(int a, unsigned b) { return max(static_cast<unsigned>(a), b); }
static inline double min(float a, double b) { return fmin(a, b); }
static inline double min(double a, float b) { return fmin(a, b); }
static inline double max(float a, double b) { return fmax(a, b); }
static inline double max(double a, float b) { return fmax(a, b); }

static inline float rsqrtf(float x) { return 1.0f / sqrtf(x); }
static inline double rsqrt(double x) { return 1.0 / sqrt(x); }
static inline float rsqrt(float x) { return 1.0f / sqrtf(x); }
static inline float __fdividef(float a, float b) { return a / b; }
// The C library declares functions of these names.
#define __expf(x) expf(x)
#define __exp10f(x) powf(10.0f, x)
#define __logf(x) logf(x)
#define __log2f(x) log2f(x)
#define __log10f(x) log10f(x)
#define __sinf(x) sinf(x)
#define __cosf(x) cosf(x)
#define __tanf(x) tanf(x)
#define __powf(x, y) powf(x, y)
static inline float __saturatef(float x) { return x < 0 ? 0.0f : x > 1 ? 1.0f : x; }
static inline float __fadd_rn(float a, float b) { return a + b; }
static inline float __fsub_rn(float a, float b) { return a - b; }
static inline float __fmul_rn(float a, float b) { return a * b; }
static inline float __fdiv_rn(float a, float b) { return a / b; }
static inline float __fsqrt_rn(float a) { return sqrtf(a); }
static inline float __frcp_rn(float a) { return 1.0f / a; }
static inline float __frsqrt_rn(float a) { return 1.0f / sqrtf(a); }
static inline float __fmaf_rn(float a, float b, float c) { return fmaf(a, b, c); }
static inline double __dadd_rn(double a, double b) { return a + b; }
static inline double __dmul_rn(double a, double b) { return a * b; }
static inline double __fma_rn(double a, double b, double c) { return fma(a, b, c); }

static inline int __popc(unsigned x) { return __builtin_popcount(x); }
static inline int __popcll(unsigned long long x) { return __builtin_popcountll(x); }
static inline int __clz(int x) { return x == 0 ? 32 : __builtin_clz(static_cast<unsigned>(x)); }
static inline int __clzll(long long x) {
    return x == 0 ? 64 : __builtin_clzll(static_cast<unsigned long long>(x));
}
static inline int __ffs(int x) { return __builtin_ffs(x); }
static inline int __ffsll(long long x) { return __builtin_ffsll(x); }
static inline unsigned __brev(unsigned x) {
    unsigned r = 0;
    for (int i = 0; i < 32; ++i) r |= (x >> i & 1u) << (31 - i);
    return r;
}
static inline unsigned long long __brevll(unsigned long long x) {
    return static_cast<unsigned long long>(__brev(static_cast<unsigned>(x))) << 32 |
           __brev(static_cast<unsigned>(x >> 32));
}
static inline unsigned __byte_perm(unsigned x, unsigned y, unsigned s) {
    const unsigned long long both = static_cast<unsigned long long>(y) << 32 | x;
    unsigned r = 0;
    for (int i = 0; i < 4; ++i)
        r |= static_cast<unsigned>(both >> (s >> 4 * i & 7u) * 8 & 0xffu) << 8 * i;
    return r;
}
static inline unsigned __funnelshift_l(unsigned low, unsigned high, unsigned shift) {
    const unsigned s = shift & 31u;
    return s == 0 ? high : high << s | low >> (32 - s);
}
static inline unsigned __funnelshift_r(unsigned low, unsigned high, unsigned shift) {
    const unsigned s = shift & 31u;
    return s == 0 ? low : high << (32 - s) | low >> s;
}
static inline int __mul24(int a, int b) { return (a << 8 >> 8) * (b << 8 >> 8); }
static inline unsigned __umul24(unsigned a, unsigned b) {
    return (a & 0xffffffu) * (b & 0xffffffu);
}
static inline int __mulhi(int a, int b) { return static_cast<int>((int64_t{a} * b) >> 32); }
static inline unsigned __umulhi(unsigned a, unsigned b) {
    return static_cast<unsigned>((uint64_t{a} * b) >> 32);
}
static inline unsigned __sad(int a, int b, unsigned c) {
    return c + static_cast<unsigned>(a < b ? b - a : a - b);
}

template <class To, class From>
static inline To scotty_bits(From from) {
    static_assert(sizeof(To) == sizeof(From), "the same bits");
    To to;
    __builtin_memcpy(&to, &from, sizeof to);
    return to;
}
static inline int __float_as_int(float x) { return scotty_bits<int>(x); }
static inline unsigned __float_as_uint(float x) { return scotty_bits<unsigned>(x); }
static inline float __int_as_float(int x) { return scotty_bits<float>(x); }
static inline float __uint_as_float(unsigned x) { return scotty_bits<float>(x); }
static inline long long __double_as_longlong(double x) { return scotty_bits<long long>(x); }
static inline double __longlong_as_double(long long x) { return scotty_bits<double>(x); }
static inline int __float2int_rn(float x) { return static_cast<int>(rintf(x)); }
static inline int __float2int_rz(float x) { return static_cast<int>(x); }
static inline int __float2int_rd(float x) { return static_cast<int>(floorf(x)); }
static inline int __float2int_ru(float x) { return static_cast<int>(ceilf(x)); }
static inline unsigned __float2uint_rn(float x) { return static_cast<unsigned>(rintf(x)); }
static inline unsigned __float2uint_rz(float x) { return static_cast<unsigned>(x); }
static inline float __int2float_rn(int x) { return static_cast<float>(x); }
static inline float __uint2float_rn(unsigned x) { return static_cast<float>(x); }
static inline int __double2int_rn(double x) { return static_cast<int>(rint(x)); }
static inline int __double2int_rz(double x) { return static_cast<int>(x); }
static inline double __int2double_rn(int x) { return x; }
static inline float __double2float_rn(double x) { return static_cast<float>(x); }

#define SCOTTY_LOAD(name)                    \
    template <class T>                       \
    static inline T name(const T* address) { \
        return *address;                     \
    }
SCOTTY_LOAD(__ldg)
SCOTTY_LOAD(__ldca)
SCOTTY_LOAD(__ldcg)
SCOTTY_LOAD(__ldcs)
SCOTTY_LOAD(__ldlu)
SCOTTY_LOAD(__ldcv)
#undef SCOTTY_LOAD
#define SCOTTY_STORE(name)                         \
    template <class T>                             \
    static inline void name(T* address, T value) { \
        *address = value;                          \
    }
SCOTTY_STORE(__stwb)
SCOTTY_STORE(__stcg)
SCOTTY_STORE(__stcs)
SCOTTY_STORE(__stwt)
#undef SCOTTY_STORE
static inline bool __isGlobal(const void*) { return true; }
static inline void __prof_trigger(int) {}
// NOLINTEND
