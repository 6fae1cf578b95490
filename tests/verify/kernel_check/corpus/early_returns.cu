// Threads that return before a barrier: CUDA's barriers do not wait for them.
#include "corpus.h"

// [clean] those beyond the end return first
__global__ void beyond_end(int* out, int n) {
    if (threadIdx.x >= n) return;
    __syncthreads();
    out[threadIdx.x] = 1;
}

// [divergence] those beyond the end skip the barrier, and reach the kernel's
__global__ void skip(int* out, int n) {
    if (threadIdx.x < n) {
        __syncthreads();
        out[threadIdx.x] = 1;
    }
}

// [clean] a whole block returns
__global__ void whole_block(int* out) {
    if (blockIdx.x == 1) return;
    __syncthreads();
    out[threadIdx.x] = 1;
}

// [data race] what a thread that returned should have written is not there, and others go on
__global__ void others_go_on(int* out, int n) {
    __shared__ int s[64];
    if (threadIdx.x >= n) return;
    s[threadIdx.x] = 1;
    if (threadIdx.x == 0) s[1] = 2;
    __syncthreads();
    out[threadIdx.x] = s[threadIdx.x];
}

// [unwritten memory] the others' part of an array is read
__global__ void part_missing(int* out, int n) {
    __shared__ int s[64];
    if (threadIdx.x >= n) return;
    s[threadIdx.x] = 1;
    __syncthreads();
    out[threadIdx.x] = s[63 - threadIdx.x];
}

// [clean] only what is there
__global__ void part(int* out, int n) {
    __shared__ int s[64];
    if (threadIdx.x >= n) return;
    s[threadIdx.x] = 1;
    __syncthreads();
    out[threadIdx.x] = s[n - 1 - threadIdx.x];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(beyond_end<<<1, 64>>>(out, 50));
    RUN(skip<<<1, 64>>>(out, 50));
    RUN(whole_block<<<2, 64>>>(out));
    RUN(others_go_on<<<1, 64>>>(out, 50));
    RUN(part_missing<<<1, 64>>>(out, 50));
    RUN(part<<<1, 64>>>(out, 50));
    cudaFree(out);
}
