/// SCOTTY_HD marks what a kernel may call: host and device code under nvcc, plain C++ elsewhere.
/// SCOTTY_STAGE marks a stage's text for one ray or pixel (reference/stages/): the same, inlined
/// wherever it is called, so that the checker sees its loads and stores as the kernel's own.
///
/// Headers that carry it keep to a C++17 subset without containers and exceptions, and to the exact
/// arithmetic set of docs/design.md (add, multiply, divide, square root, explicit fma), so that CPU
/// and GPU agree bit for bit.
#pragma once

#if defined(__CUDACC__)
#define SCOTTY_HD __host__ __device__ inline
#define SCOTTY_STAGE __host__ __device__ __forceinline__
#define SCOTTY_UNROLL _Pragma("unroll")  ///< before a loop whose arrays are to stay in registers
#else
#define SCOTTY_HD inline
#define SCOTTY_STAGE [[gnu::always_inline]] inline
#define SCOTTY_UNROLL
#endif
