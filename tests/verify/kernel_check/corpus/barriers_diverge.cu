// Barriers that not all threads of a block reach, or not the same ones.
#include "corpus.h"

// [divergence] a barrier under a condition that differs
__global__ void under_condition(int* out) {
    if (threadIdx.x < 16) __syncthreads();
    out[threadIdx.x] = 1;
}

// [clean] under a condition that is the same for all
__global__ void under_uniform_condition(int* out, int n) {
    if (n > 0) __syncthreads();
    out[threadIdx.x] = 1;
}

// [divergence] one barrier in each branch
__global__ void two_barriers(int* out) {
    if (threadIdx.x < 32) {
        __syncthreads();
    } else {
        __syncthreads();
    }
    out[threadIdx.x] = 1;
}

// [clean] one behind both
__global__ void one_barrier(int* out) {
    if (threadIdx.x < 32) {
        out[threadIdx.x] = 1;
    } else {
        out[threadIdx.x] = 2;
    }
    __syncthreads();
}

// [divergence] a loop that threads leave after different rounds
__global__ void rounds_differ(int* out) {
    for (int i = 0; i < threadIdx.x; ++i) __syncthreads();
    out[threadIdx.x] = 1;
}

// [clean] the same number of rounds
__global__ void rounds_same(int* out) {
    for (int i = 0; i < blockDim.x; ++i) __syncthreads();
    out[threadIdx.x] = 1;
}

// [divergence] inside a function that is called
__device__ void helper(int n) {
    if (n % 2 == 0) __syncthreads();
}
__global__ void in_function(int* out) {
    helper(threadIdx.x);
    out[threadIdx.x] = 1;
}

// [clean] counts, ands and ors at barriers
__global__ void predicates(int* out) {
    const int count = __syncthreads_count(threadIdx.x < 10);
    const int both = __syncthreads_and(threadIdx.x < 64);
    const int any = __syncthreads_or(threadIdx.x == 63);
    if (count != 10 || both == 0 || any == 0) __trap();
    out[threadIdx.x] = count;
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(under_condition<<<1, 64>>>(out));
    RUN(under_uniform_condition<<<1, 64>>>(out, 1));
    RUN(two_barriers<<<1, 64>>>(out));
    RUN(one_barrier<<<1, 64>>>(out));
    RUN(rounds_differ<<<1, 64>>>(out));
    RUN(rounds_same<<<1, 64>>>(out));
    RUN(in_function<<<1, 64>>>(out));
    RUN(predicates<<<1, 64>>>(out));
    cudaFree(out);
}
