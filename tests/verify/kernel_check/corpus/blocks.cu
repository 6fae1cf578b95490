// Blocks of one launch meet in device memory: a barrier of one block does not order another.
#include "corpus.h"

// [data race] the neighbouring block's element is read
__global__ void halo(int* a) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    const int v = a[i + 1];
    __syncthreads();
    a[i] = v;
}

// [clean] into another array
__global__ void halo_apart(const int* a, int* b) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    b[i] = a[i + 1];
}

// [data race] a histogram with plain increments
__global__ void histogram_plain(int* bins) { bins[threadIdx.x % 8]++; }

// [clean] with atomics
__global__ void histogram(int* bins) { atomicAdd(&bins[threadIdx.x % 8], 1); }

// [data race] every block clears what another fills
__global__ void clear_and_fill(int* a) {
    if (threadIdx.x == 0) a[0] = 0;
    __syncthreads();
    atomicAdd(a, 1);
}

// [clean] block 0 alone does both
__global__ void clear_and_fill_alone(int* a) {
    if (blockIdx.x != 0) return;
    if (threadIdx.x == 0) a[0] = 0;
    __syncthreads();
    atomicAdd(a, 1);
}

// [data race] ranges of blocks overlap by one element
__global__ void overlapping(int* a) {
    for (int i = blockIdx.x * 16; i <= blockIdx.x * 16 + 16; ++i) a[i] = blockIdx.x;
}

// [clean] ranges side by side
__global__ void side_by_side(int* a) {
    for (int i = blockIdx.x * 16; i < blockIdx.x * 16 + 16; ++i) a[i] = blockIdx.x;
}

// [clean] many readers of one value
__global__ void common_input(const int* a, int* b) {
    b[blockIdx.x * blockDim.x + threadIdx.x] = a[0];
}

// [main]
int main() {
    int* a = zeros<int>(512);
    int* b = zeros<int>(512);
    RUN(halo<<<4, 32>>>(a));
    RUN(halo_apart<<<4, 32>>>(a, b));
    RUN(histogram_plain<<<2, 8>>>(a));
    RUN(histogram<<<2, 8>>>(a));
    RUN(clear_and_fill<<<2, 32>>>(a));
    RUN(clear_and_fill_alone<<<2, 32>>>(a));
    RUN(overlapping<<<4, 1>>>(a));
    RUN(side_by_side<<<4, 1>>>(a));
    RUN(common_input<<<4, 64>>>(a, b));
    cudaFree(a);
    cudaFree(b);
}
