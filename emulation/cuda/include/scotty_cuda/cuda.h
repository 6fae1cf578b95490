/// Everything that CUDA text finds without an include. scotty check puts it in front of each file.
#pragma once

#include "atomics.h"
#include "copies.h"
#include "interface.h"
#include "intrinsics.h"
#include "launch.h"
#include "runtime.h"
#include "vector_types.h"
#include "warp.h"

#include <new>

#include <stdio.h>
#undef NDEBUG
#include <assert.h>

// NOLINTBEGIN
#define __CUDACC__ 1
#define __NVCC__ 1
#define __CUDA_ARCH__ 800
#define __CUDACC_VER_MAJOR__ 12
#define __CUDACC_VER_MINOR__ 0
#define CUDART_VERSION 12000
#define __forceinline__ inline __attribute__((always_inline))
#define __align__(bytes) __attribute__((aligned(bytes)))
#define __launch_bounds__(...)
#define __grid_constant__
#define __restrict__ __restrict
#define CUDART_INF_F __builtin_inff()
#define CUDART_INF __builtin_inf()
#define CUDART_PI_F 3.141592654f
// NOLINTEND
