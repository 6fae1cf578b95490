// Atomics and fences that hold for a block only, used across blocks.
#include <cuda/atomic>

#include "corpus.h"

// [data race] atomicAdd_block by several blocks
__global__ void block_add(int* a) { atomicAdd_block(a, 1); }

// [clean] each block has a place of its own
__global__ void block_add_apart(int* a) { atomicAdd_block(a + blockIdx.x, 1); }

// [data race] one block atomically for itself, the other for all
__global__ void mixed_add(int* a) {
    if (blockIdx.x == 0) {
        atomicAdd_block(a, 1);
    } else {
        atomicAdd(a, 1);
    }
}

// [clean] all for all
__global__ void system_add(int* a) {
    if (blockIdx.x == 0) {
        atomicAdd_system(a, 1);
    } else {
        atomicAdd(a, 1);
    }
}

// [data race] an atomic_ref of the block's scope
__global__ void reference_block(int* a) {
    cuda::atomic_ref<int, cuda::thread_scope_block>(*a).fetch_add(1, cuda::memory_order_relaxed);
}

// [clean] of the device's scope
__global__ void reference_device(int* a) {
    cuda::atomic_ref<int, cuda::thread_scope_device>(*a).fetch_add(1, cuda::memory_order_relaxed);
}

// [data race] the fence reaches the own block only
__global__ void weak_fence(int* data, int* flag) {
    if (blockIdx.x == 0) {
        data[0] = 1;
        __threadfence_block();
        atomicExch(flag, 1);
    } else {
        while (atomicAdd(flag, 0) == 0) {
        }
        __threadfence();
        data[1] = data[0];
    }
}

// [clean] the fence reaches all
__global__ void strong_fence(int* data, int* flag) {
    if (blockIdx.x == 0) {
        data[0] = 1;
        __threadfence();
        atomicExch(flag, 1);
    } else {
        while (atomicAdd(flag, 0) == 0) {
        }
        __threadfence();
        data[1] = data[0];
    }
}

// [main]
int main() {
    int* a = zeros<int>(64);
    int* b = zeros<int>(64);
    int* c = zeros<int>(64);
    RUN(block_add<<<2, 32>>>(a));
    RUN(block_add_apart<<<2, 32>>>(a));
    RUN(mixed_add<<<2, 32>>>(a));
    RUN(system_add<<<2, 32>>>(a));
    RUN(reference_block<<<2, 32>>>(a));
    RUN(reference_device<<<2, 32>>>(a));
    RUN(weak_fence<<<2, 1>>>(a, b));
    RUN(strong_fence<<<2, 1>>>(a, c));
    cudaFree(a);
    cudaFree(b);
    cudaFree(c);
}
