// Threads that wait for what will not happen.
#include "corpus.h"

// [endless wait] nobody sets the flag
__global__ void no_setter(int* flag) {
    while (atomicAdd(flag, 0) == 0) {
    }
}

// [clean] another block does
__global__ void with_setter(int* flag) {
    if (blockIdx.x == 1) {
        atomicExch(flag, 1);
    } else {
        while (atomicAdd(flag, 0) == 0) {
        }
    }
}

// [endless wait] the lock is never given back
__global__ void lock_kept(int* lock) {
    while (atomicCAS(lock, 0, 1) != 0) {
    }
}

// [clean] it is
__global__ void lock_given_back(int* lock) {
    while (atomicCAS(lock, 0, 1) != 0) {
    }
    atomicExch(lock, 0);
}

// [endless wait] the setter waits at a barrier for those who poll
__global__ void setter_waits(volatile int* flag) {
    if (threadIdx.x != 0) {
        while (*flag == 0) {
        }
    }
    __syncthreads();
    if (threadIdx.x == 0) *flag = 1;
}

// [clean] the setter comes first
__global__ void setter_first(volatile int* flag) {
    if (threadIdx.x == 0) {
        __threadfence();
        *flag = 1;
    } else {
        while (*flag == 0) {
        }
    }
    __syncthreads();
}

// [endless wait] a loop on plain memory
__global__ void plain_loop(int* flag) {
    while (flag[0] == 0) {
    }
}

// [main]
int main() {
    int* flag = zeros<int>(8);
    RUN(no_setter<<<1, 2>>>(flag));
    RUN(with_setter<<<2, 1>>>(flag + 1));
    RUN(lock_kept<<<2, 1>>>(flag + 2));
    RUN(lock_given_back<<<2, 32>>>(flag + 3));
    RUN(setter_waits<<<1, 2>>>(flag + 4));
    RUN(setter_first<<<1, 32>>>(flag + 5));
    RUN(plain_loop<<<1, 1>>>(flag + 6));
    cudaFree(flag);
}
