// Memory that nobody has written.
#include "corpus.h"

// [unwritten memory] device memory is read as it comes
__global__ void as_it_comes(const int* a, int* out) { out[threadIdx.x] = a[threadIdx.x]; }
void fresh(int* out) {
    int* a = nullptr;
    cudaMalloc(&a, 32 * sizeof(int));
    as_it_comes<<<1, 32>>>(a, out);
    cudaFree(a);
}

// [clean] set before
__global__ void after_memset(const int* a, int* out) { out[threadIdx.x] = a[threadIdx.x]; }
void set_before(int* out) {
    int* a = zeros<int>(32);
    after_memset<<<1, 32>>>(a, out);
    cudaFree(a);
}

// [unwritten memory] half of it was copied
__global__ void half_copied(const int* a, int* out) { out[threadIdx.x] = a[threadIdx.x]; }
void copy_half(int* out) {
    int host[32] = {};
    int* a = nullptr;
    cudaMalloc(&a, sizeof host);
    cudaMemcpy(a, host, 32, cudaMemcpyHostToDevice);
    half_copied<<<1, 32>>>(a, out);
    cudaFree(a);
}

// [unwritten memory] a sum begins with whatever there is in shared memory
__global__ void sum_from_nothing(int* out) {
    __shared__ int sum;
    atomicAdd(&sum, 1);
    __syncthreads();
    out[threadIdx.x] = sum;
}

// [clean] with zero
__global__ void sum_from_zero(int* out) {
    __shared__ int sum;
    if (threadIdx.x == 0) sum = 0;
    __syncthreads();
    atomicAdd(&sum, 1);
    __syncthreads();
    out[threadIdx.x] = sum;
}

// [unwritten memory] the edge of a tile is not filled
__global__ void edge(int* out) {
    __shared__ int tile[34];
    tile[threadIdx.x + 1] = threadIdx.x;
    __syncthreads();
    out[threadIdx.x] = tile[threadIdx.x] + tile[threadIdx.x + 2];
}

// [clean] it is
__global__ void edge_filled(int* out) {
    __shared__ int tile[34];
    tile[threadIdx.x + 1] = threadIdx.x;
    if (threadIdx.x < 2) tile[threadIdx.x * 33] = 0;
    __syncthreads();
    out[threadIdx.x] = tile[threadIdx.x] + tile[threadIdx.x + 2];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(fresh(out));
    RUN(set_before(out));
    RUN(copy_half(out));
    RUN(sum_from_nothing<<<1, 32>>>(out));
    RUN(sum_from_zero<<<1, 32>>>(out));
    RUN(edge<<<1, 32>>>(out));
    RUN(edge_filled<<<1, 32>>>(out));
    cudaFree(out);
}
