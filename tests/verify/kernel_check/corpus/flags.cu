// One thread hands data to another through a flag.
#include <cuda/atomic>

#include "corpus.h"

// [data race] no fence before the flag
__global__ void no_fence(int* data, int* flag) {
    if (blockIdx.x == 0) {
        data[0] = 1;
        atomicExch(flag, 1);
    } else {
        while (atomicAdd(flag, 0) == 0) {
        }
        __threadfence();
        data[1] = data[0];
    }
}

// [clean] fences on both sides
__global__ void with_fence(int* data, int* flag) {
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

// [clean] a volatile flag, with fences
__global__ void volatile_flag(int* data, volatile int* flag) {
    if (blockIdx.x == 0) {
        data[0] = 1;
        __threadfence();
        *flag = 1;
    } else {
        while (*flag == 0) {
        }
        __threadfence();
        data[1] = data[0];
    }
}

// [data race] a volatile flag without fences
__global__ void volatile_flag_bare(int* data, volatile int* flag) {
    if (blockIdx.x == 0) {
        data[0] = 1;
        *flag = 1;
    } else {
        while (*flag == 0) {
        }
        data[1] = data[0];
    }
}

// [clean] release and acquire
__global__ void release_acquire(int* data, int* flag) {
    cuda::atomic_ref<int, cuda::thread_scope_device> f(*flag);
    if (blockIdx.x == 0) {
        data[0] = 1;
        f.store(1, cuda::memory_order_release);
    } else {
        while (f.load(cuda::memory_order_acquire) == 0) {
        }
        data[1] = data[0];
    }
}

// [data race] relaxed on both sides
__global__ void relaxed(int* data, int* flag) {
    cuda::atomic_ref<int, cuda::thread_scope_device> f(*flag);
    if (blockIdx.x == 0) {
        data[0] = 1;
        f.store(1, cuda::memory_order_relaxed);
    } else {
        while (f.load(cuda::memory_order_relaxed) == 0) {
        }
        data[1] = data[0];
    }
}

// [data race] the flag is set before the data
__global__ void wrong_order(int* data, int* flag) {
    if (blockIdx.x == 0) {
        atomicExch(flag, 1);
        __threadfence();
        data[0] = 1;
    } else {
        while (atomicAdd(flag, 0) == 0) {
        }
        __threadfence();
        data[1] = data[0];
    }
}

// [clean] a whole block hands over, by its thread 0
__global__ void block_hands_over(int* data, int* flag) {
    if (blockIdx.x == 0) {
        data[threadIdx.x] = threadIdx.x;
        __syncthreads();
        if (threadIdx.x == 0) {
            __threadfence();
            atomicExch(flag, 1);
        }
    } else {
        if (threadIdx.x == 0) {
            while (atomicAdd(flag, 0) == 0) {
            }
            __threadfence();
        }
        __syncthreads();
        data[32 + threadIdx.x] = data[31 - threadIdx.x];
    }
}

// [data race] thread 0 does not wait for the others of its block
__global__ void block_hands_over_early(int* data, int* flag) {
    if (blockIdx.x == 0) {
        data[threadIdx.x] = threadIdx.x;
        if (threadIdx.x == 0) {
            __threadfence();
            atomicExch(flag, 1);
        }
    } else {
        if (threadIdx.x == 0) {
            while (atomicAdd(flag, 0) == 0) {
            }
            __threadfence();
        }
        __syncthreads();
        data[32 + threadIdx.x] = data[31 - threadIdx.x];
    }
}

// [main]
int main() {
    int* data = zeros<int>(64);
    int* flags = zeros<int>(64);
    RUN(no_fence<<<2, 1>>>(data, flags));
    RUN(with_fence<<<2, 1>>>(data, flags + 1));
    RUN(volatile_flag<<<2, 1>>>(data, flags + 2));
    RUN(volatile_flag_bare<<<2, 1>>>(data, flags + 3));
    RUN(release_acquire<<<2, 1>>>(data, flags + 4));
    RUN(relaxed<<<2, 1>>>(data, flags + 5));
    RUN(wrong_order<<<2, 1>>>(data, flags + 6));
    RUN(block_hands_over<<<2, 32>>>(data, flags + 7));
    RUN(block_hands_over_early<<<2, 32>>>(data, flags + 8));
    cudaFree(data);
    cudaFree(flags);
}
