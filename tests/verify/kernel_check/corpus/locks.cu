// Critical sections.
#include <cuda/atomic>

#include "corpus.h"

// [clean] a lock with fences
__global__ void lock_with_fences(int* lock, int* data) {
    if (threadIdx.x != 0) return;
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[0] += 1;
    __threadfence();
    atomicExch(lock, 0);
}

// [data race] unlocked without a fence
__global__ void lock_without_fence(int* lock, int* data) {
    if (threadIdx.x != 0) return;
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[0] += 1;
    atomicExch(lock, 0);
}

// [data race] not all that access the data lock
__global__ void lock_forgotten(int* lock, int* data) {
    if (threadIdx.x != 0) return;
    if (blockIdx.x == 0) {
        data[0] += 1;
        return;
    }
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[0] += 1;
    __threadfence();
    atomicExch(lock, 0);
}

// [data race] two locks for one place
__global__ void two_locks(int* locks, int* data) {
    if (threadIdx.x != 0) return;
    int* lock = locks + blockIdx.x % 2;
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[0] += 1;
    __threadfence();
    atomicExch(lock, 0);
}

// [clean] one lock each for two places
__global__ void two_places(int* locks, int* data) {
    if (threadIdx.x != 0) return;
    int* lock = locks + blockIdx.x % 2;
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[blockIdx.x % 2] += 1;
    __threadfence();
    atomicExch(lock, 0);
}

// [clean] acquire and release instead of fences
__global__ void lock_acquire(int* lock, int* data) {
    cuda::atomic_ref<int, cuda::thread_scope_device> l(*lock);
    while (l.exchange(1, cuda::memory_order_acquire) != 0) {
    }
    data[0] += 1;
    l.store(0, cuda::memory_order_release);
}

// [clean] lanes of one warp take the lock in turn
__global__ void lanes_in_turn(int* lock, int* data) {
    bool done = false;
    while (!done) {
        if (atomicCAS(lock, 0, 1) == 0) {
            __threadfence();
            data[0] += 1;
            __threadfence();
            atomicExch(lock, 0);
            done = true;
        }
    }
}

// [data race] the lock holds for a block, and blocks share the data
__global__ void lock_of_block(int* lock, int* data) {
    if (threadIdx.x != 0) return;
    while (atomicCAS_block(lock, 0, 1) != 0) {
    }
    __threadfence();
    data[0] += 1;
    __threadfence();
    atomicExch_block(lock, 0);
}

// [main]
int main() {
    int* lock = zeros<int>(8);
    int* data = zeros<int>(8);
    RUN(lock_with_fences<<<4, 32>>>(lock, data));
    RUN(lock_without_fence<<<4, 32>>>(lock, data));
    RUN(lock_forgotten<<<4, 32>>>(lock, data));
    RUN(two_locks<<<4, 32>>>(lock, data));
    RUN(two_places<<<4, 32>>>(lock, data));
    RUN(lock_acquire<<<4, 1>>>(lock, data));
    RUN(lanes_in_turn<<<2, 32>>>(lock, data));
    RUN(lock_of_block<<<4, 32>>>(lock, data));
    cudaFree(lock);
    cudaFree(data);
}
