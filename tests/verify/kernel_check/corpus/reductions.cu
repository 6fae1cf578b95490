// Sums over a block and over a grid.
#include "corpus.h"

// [data race] halves are added without a barrier in between
__global__ void tree_without(int* out) {
    __shared__ int s[128];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    for (int half = 64; half > 0; half /= 2) {
        if (threadIdx.x < half) s[threadIdx.x] += s[threadIdx.x + half];
    }
    if (threadIdx.x == 0) out[0] = s[0];
}

// [clean] a barrier after each step
__global__ void tree(int* out) {
    __shared__ int s[128];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    for (int half = 64; half > 0; half /= 2) {
        if (threadIdx.x < half) s[threadIdx.x] += s[threadIdx.x + half];
        __syncthreads();
    }
    if (threadIdx.x == 0) out[0] = s[0];
}

// [data race] the last warp relies on its lanes going in step
__global__ void last_warp_in_step(int* out) {
    __shared__ int s[64];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    if (threadIdx.x < 32) {
        s[threadIdx.x] += s[threadIdx.x + 32];
        s[threadIdx.x] += s[threadIdx.x + 16];
        s[threadIdx.x] += s[threadIdx.x + 8];
    }
    if (threadIdx.x == 0) out[0] = s[0];
}

// [clean] the last warp synchronises between reads and writes
__global__ void last_warp(int* out) {
    __shared__ int s[64];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    if (threadIdx.x < 32) {
        int v = s[threadIdx.x];
        for (int apart = 32; apart > 0; apart /= 2) {
            v += s[threadIdx.x + apart];
            __syncwarp();
            s[threadIdx.x] = v;
            __syncwarp();
        }
        if (threadIdx.x == 0) out[0] = v;
    }
}

// [data race] blocks add to one place plainly
__global__ void grid_plain(int* out) {
    if (threadIdx.x == 0) out[0] += blockIdx.x;
}

// [clean] and atomically
__global__ void grid_atomic(int* out) {
    if (threadIdx.x == 0) atomicAdd(out, blockIdx.x);
}

// [clean] warps by shuffles, their sums through shared memory
__global__ void shuffles(int* out) {
    __shared__ int sums[4];
    int v = threadIdx.x;
    for (int apart = 16; apart > 0; apart /= 2) v += __shfl_down_sync(0xffffffff, v, apart);
    if (threadIdx.x % 32 == 0) sums[threadIdx.x / 32] = v;
    __syncthreads();
    if (threadIdx.x == 0) out[0] = sums[0] + sums[1] + sums[2] + sums[3];
}

// [data race] the sums of the warps are read at once
__global__ void shuffles_early(int* out) {
    __shared__ int sums[4];
    int v = threadIdx.x;
    for (int apart = 16; apart > 0; apart /= 2) v += __shfl_down_sync(0xffffffff, v, apart);
    if (threadIdx.x % 32 == 0) sums[threadIdx.x / 32] = v;
    if (threadIdx.x == 0) out[0] = sums[0] + sums[1] + sums[2] + sums[3];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(tree_without<<<1, 128>>>(out));
    RUN(tree<<<1, 128>>>(out));
    RUN(last_warp_in_step<<<1, 64>>>(out));
    RUN(last_warp<<<1, 64>>>(out));
    RUN(grid_plain<<<4, 32>>>(out));
    RUN(grid_atomic<<<4, 32>>>(out));
    RUN(shuffles<<<1, 128>>>(out));
    RUN(shuffles_early<<<1, 128>>>(out));
    cudaFree(out);
}
