// Lanes of a warp meet in memory: only __syncwarp orders them.
#include "corpus.h"

// [data race] lanes are thought to go in step
__global__ void in_step(int* out) {
    __shared__ int s[32];
    s[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = s[31 - threadIdx.x];
}

// [clean] with __syncwarp
__global__ void synchronised(int* out) {
    __shared__ int s[32];
    s[threadIdx.x] = threadIdx.x;
    __syncwarp();
    out[threadIdx.x] = s[31 - threadIdx.x];
}

// [data race] a shuffle orders no memory
__global__ void shuffle_orders_nothing(int* out) {
    __shared__ int s[32];
    s[threadIdx.x] = threadIdx.x;
    const int v = __shfl_xor_sync(0xffffffff, threadIdx.x, 1);
    out[threadIdx.x] = s[31 - threadIdx.x] + v;
}

// [clean] one value for the warp, read behind __syncwarp, set again behind another
__global__ void value_of_warp(int* out) {
    __shared__ int s;
    for (int i = 0; i < 3; ++i) {
        if (threadIdx.x == 0) s = i;
        __syncwarp();
        out[threadIdx.x] = s;
        __syncwarp();
    }
}

// [data race] set again too early
__global__ void value_of_warp_early(int* out) {
    __shared__ int s;
    for (int i = 0; i < 3; ++i) {
        if (threadIdx.x == 0) s = i;
        __syncwarp();
        out[threadIdx.x] = s;
    }
}

// [data race] two warps, and each synchronises for itself
__global__ void two_warps(int* out) {
    __shared__ int s[64];
    s[threadIdx.x] = threadIdx.x;
    __syncwarp();
    out[threadIdx.x] = s[63 - threadIdx.x];
}

// [clean] halves of a warp, each with its mask
__global__ void halves(int* out) {
    __shared__ int s[32];
    s[threadIdx.x] = threadIdx.x;
    const unsigned mask = threadIdx.x < 16 ? 0x0000ffffu : 0xffff0000u;
    __syncwarp(mask);
    out[threadIdx.x] = s[threadIdx.x ^ 1];
}

// [data race] the mask does not name the lane that is read
__global__ void wrong_half(int* out) {
    __shared__ int s[32];
    s[threadIdx.x] = threadIdx.x;
    const unsigned mask = threadIdx.x < 16 ? 0x0000ffffu : 0xffff0000u;
    __syncwarp(mask);
    out[threadIdx.x] = s[threadIdx.x ^ 16];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(in_step<<<1, 32>>>(out));
    RUN(synchronised<<<1, 32>>>(out));
    RUN(shuffle_orders_nothing<<<1, 32>>>(out));
    RUN(value_of_warp<<<1, 32>>>(out));
    RUN(value_of_warp_early<<<1, 32>>>(out));
    RUN(two_warps<<<1, 64>>>(out));
    RUN(halves<<<1, 32>>>(out));
    RUN(wrong_half<<<1, 32>>>(out));
    cudaFree(out);
}
