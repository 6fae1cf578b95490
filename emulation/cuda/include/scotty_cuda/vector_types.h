/// CUDA's vector types: int2, float4, dim3 and the others, aligned as CUDA aligns them.
// The names are CUDA's.
// NOLINTBEGIN
#pragma once

#include "copies.h"

#define SCOTTY_VECTORS(T, name, align2, align4)                               \
    struct name##1 {                                                          \
        T x;                                                                  \
        SCOTTY_COPIED(name##1)                                                \
    };                                                                        \
    struct alignas(align2) name##2 {                                          \
        T x, y;                                                               \
        SCOTTY_COPIED(name##2)                                                \
    };                                                                        \
    struct name##3 {                                                          \
        T x, y, z;                                                            \
        SCOTTY_COPIED(name##3)                                                \
    };                                                                        \
    struct alignas(align4) name##4 {                                          \
        T x, y, z, w;                                                         \
        SCOTTY_COPIED(name##4)                                                \
    };                                                                        \
    static inline name##1 make_##name##1(T x) { return {x}; }                 \
    static inline name##2 make_##name##2(T x, T y) { return {x, y}; }         \
    static inline name##3 make_##name##3(T x, T y, T z) { return {x, y, z}; } \
    static inline name##4 make_##name##4(T x, T y, T z, T w) { return {x, y, z, w}; }

SCOTTY_VECTORS(signed char, char, 2, 4)
SCOTTY_VECTORS(unsigned char, uchar, 2, 4)
SCOTTY_VECTORS(short, short, 4, 8)
SCOTTY_VECTORS(unsigned short, ushort, 4, 8)
SCOTTY_VECTORS(int, int, 8, 16)
SCOTTY_VECTORS(unsigned int, uint, 8, 16)
SCOTTY_VECTORS(long, long, 16, 16)
SCOTTY_VECTORS(unsigned long, ulong, 16, 16)
SCOTTY_VECTORS(long long, longlong, 16, 16)
SCOTTY_VECTORS(unsigned long long, ulonglong, 16, 16)
SCOTTY_VECTORS(float, float, 8, 16)
SCOTTY_VECTORS(double, double, 16, 16)
#undef SCOTTY_VECTORS

struct dim3 {
    unsigned int x, y, z;
    constexpr dim3(unsigned int vx = 1, unsigned int vy = 1, unsigned int vz = 1)
        : x(vx), y(vy), z(vz) {}
    constexpr dim3(uint3 v) : x(v.x), y(v.y), z(v.z) {}
    constexpr operator uint3() const { return {x, y, z}; }
};

inline uint3 threadIdx;
inline uint3 blockIdx;
inline dim3 blockDim;
inline dim3 gridDim;
constexpr int warpSize = 32;
// NOLINTEND
