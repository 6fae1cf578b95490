// Faults inside functions that kernels call, and dynamic shared memory declared outside of them.
#include "corpus.h"

extern __shared__ int dynamic[];

// [data race] the function forgets its barrier
__device__ int neighbour_of(int* s, int v) {
    s[threadIdx.x] = v;
    return s[(threadIdx.x + 1) % 32];
}
__global__ void calls(int* out) {
    __shared__ int s[32];
    out[threadIdx.x] = neighbour_of(s, threadIdx.x);
}

// [clean] it has one
__device__ int neighbour_behind(int* s, int v) {
    s[threadIdx.x] = v;
    __syncthreads();
    return s[(threadIdx.x + 1) % 32];
}
__global__ void calls_behind(int* out) {
    __shared__ int s[32];
    out[threadIdx.x] = neighbour_behind(s, threadIdx.x);
}

// [data race] called, and its memory is written again before all have read
__device__ int neighbour_again(int* s, int v) {
    s[threadIdx.x] = v;
    __syncthreads();
    return s[(threadIdx.x + 1) % 32];
}
__global__ void calls_again(int* out) {
    __shared__ int s[32];
    int v = neighbour_again(s, threadIdx.x);
    s[threadIdx.x] = v;
    out[threadIdx.x] = v;
}

// [clean] shared memory of a function
__device__ int own_shared(int v) {
    __shared__ int s[32];
    s[threadIdx.x] = v;
    __syncthreads();
    return s[31 - threadIdx.x];
}
__global__ void calls_own(int* out) { out[threadIdx.x] = own_shared(threadIdx.x); }

// [data race] dynamic shared memory, without the barrier
__global__ void dynamic_early(int* out) {
    dynamic[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = dynamic[31 - threadIdx.x];
}

// [clean] with it
__global__ void dynamic_behind(int* out) {
    dynamic[threadIdx.x] = threadIdx.x;
    __syncthreads();
    out[threadIdx.x] = dynamic[31 - threadIdx.x];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(calls<<<1, 32>>>(out));
    RUN(calls_behind<<<1, 32>>>(out));
    RUN(calls_again<<<1, 32>>>(out));
    RUN(calls_own<<<1, 32>>>(out));
    RUN(dynamic_early<<<1, 32, 128>>>(out));
    RUN(dynamic_behind<<<1, 32, 128>>>(out));
    cudaFree(out);
}
