// A barrier is missing between writers and readers of shared memory.
#include "corpus.h"

// [data race] a neighbour is read with no barrier behind the writes
__global__ void neighbour_early(int* out) {
    __shared__ int s[64];
    s[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = s[(threadIdx.x + 1) % 64];
}

// [clean] the same with the barrier
__global__ void neighbour(int* out) {
    __shared__ int s[64];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    out[threadIdx.x] = s[(threadIdx.x + 1) % 64];
}

// [data race] thread 0 sets what all read at once
__global__ void broadcast_early(int* out) {
    __shared__ int value;
    if (threadIdx.x == 0) value = 42;
    out[threadIdx.x] = value;
}

// [clean] the same with the barrier
__global__ void broadcast(int* out) {
    __shared__ int value;
    if (threadIdx.x == 0) value = 42;
    __syncthreads();
    out[threadIdx.x] = value;
}

// [data race] the value is set again before all have read it
__global__ void reuse_early(int* out) {
    __shared__ int value;
    for (int i = 0; i < 3; ++i) {
        if (threadIdx.x == 0) value = i;
        __syncthreads();
        out[threadIdx.x] += value;
    }
}

// [clean] a second barrier in the loop
__global__ void reuse(int* out) {
    __shared__ int value;
    for (int i = 0; i < 3; ++i) {
        if (threadIdx.x == 0) value = i;
        __syncthreads();
        out[threadIdx.x] += value;
        __syncthreads();
    }
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(neighbour_early<<<1, 64>>>(out));
    RUN(neighbour<<<1, 64>>>(out));
    RUN(broadcast_early<<<1, 64>>>(out));
    RUN(broadcast<<<1, 64>>>(out));
    RUN(reuse_early<<<1, 64>>>(out));
    RUN(reuse<<<1, 64>>>(out));
    cudaFree(out);
}
