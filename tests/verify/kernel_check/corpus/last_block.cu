// The last block adds up what the others have left, as in the sample threadFenceReduction.
#include "corpus.h"

// [clean] with the fence
__global__ void last_block(int* partial, unsigned* count, int* out) {
    __shared__ bool is_last;
    if (threadIdx.x == 0) {
        partial[blockIdx.x] = blockIdx.x;
        __threadfence();
        is_last = atomicInc(count, gridDim.x) == gridDim.x - 1;
    }
    __syncthreads();
    if (is_last && threadIdx.x < gridDim.x) atomicAdd(out, partial[threadIdx.x]);
}

// [data race] without it
__global__ void last_block_bare(int* partial, unsigned* count, int* out) {
    __shared__ bool is_last;
    if (threadIdx.x == 0) {
        partial[blockIdx.x] = blockIdx.x;
        is_last = atomicInc(count, gridDim.x) == gridDim.x - 1;
    }
    __syncthreads();
    if (is_last && threadIdx.x < gridDim.x) atomicAdd(out, partial[threadIdx.x]);
}

// [clean] all threads write, all have a fence, then a barrier
__global__ void all_fence(int* partial, unsigned* count, int* out) {
    __shared__ bool is_last;
    partial[blockIdx.x * blockDim.x + threadIdx.x] = threadIdx.x;
    __threadfence();
    __syncthreads();
    if (threadIdx.x == 0) is_last = atomicAdd(count, 1u) == gridDim.x - 1;
    __syncthreads();
    if (!is_last) return;
    for (int i = threadIdx.x; i < gridDim.x * blockDim.x; i += blockDim.x)
        atomicAdd(out, partial[i]);
}

// [data race] thread 0 counts before the others have written
__global__ void counts_early(int* partial, unsigned* count, int* out) {
    __shared__ bool is_last;
    if (threadIdx.x == 0) {
        __threadfence();
        is_last = atomicAdd(count, 1u) == gridDim.x - 1;
    }
    partial[blockIdx.x * blockDim.x + threadIdx.x] = threadIdx.x;
    __syncthreads();
    if (!is_last) return;
    for (int i = threadIdx.x; i < gridDim.x * blockDim.x; i += blockDim.x)
        atomicAdd(out, partial[i]);
}

// [main]
int main() {
    int* partial = zeros<int>(256);
    unsigned* count = zeros<unsigned>(4);
    int* out = zeros<int>(1);
    RUN(last_block<<<4, 32>>>(partial, count, out));
    RUN(last_block_bare<<<4, 32>>>(partial, count + 1, out));
    RUN(all_fence<<<4, 32>>>(partial, count + 2, out));
    RUN(counts_early<<<4, 32>>>(partial, count + 3, out));
    cudaFree(partial);
    cudaFree(count);
    cudaFree(out);
}
