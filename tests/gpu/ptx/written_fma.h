/// Marks every fma that the source asks for, so that one which the compiler made up stands out.
#pragma once

#include <cuda_runtime.h>

#include <cmath>

__host__ __device__ inline float written_fma(float a, float b, float c) {
#if defined(__CUDA_ARCH__)
    float result;
    asm("fma.rn.f32 %0, %1, %2, %3; // written" : "=f"(result) : "f"(a), "f"(b), "f"(c));
    return result;
#else
    return fmaf(a, b, c);
#endif
}
#define fmaf written_fma
