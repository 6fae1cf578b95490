// Accesses beyond shared objects, which have gaps between them here.
#include "corpus.h"

// [out of bounds] one element beyond the array, into its neighbour on a device
__global__ void into_neighbour(int* out) {
    __shared__ int a[64];
    __shared__ int b[64];
    a[threadIdx.x + 1] = 1;
    b[threadIdx.x] = 2;
    __syncthreads();
    out[threadIdx.x] = b[threadIdx.x];
}

// [clean] inside
__global__ void inside(int* out) {
    __shared__ int a[65];
    __shared__ int b[64];
    a[threadIdx.x + 1] = 1;
    b[threadIdx.x] = a[threadIdx.x + 1];
    __syncthreads();
    out[threadIdx.x] = b[threadIdx.x];
}

// [out of bounds] dynamic shared memory is smaller than what is used
__global__ void dynamic_small(int* out) {
    extern __shared__ int d[];
    d[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = d[threadIdx.x];
}

// [clean] of the right size
__global__ void dynamic_right(int* out) {
    extern __shared__ int d[];
    d[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = d[threadIdx.x];
}

// [out of bounds] before the begin
__global__ void before_begin(int* out) {
    __shared__ int a[64];
    a[static_cast<int>(threadIdx.x) - 1] = 1;
    out[threadIdx.x] = 1;
}

// [out of bounds] a row too many of a two-dimensional array
__global__ void row_too_many(int* out) {
    __shared__ int tile[8][8];
    tile[threadIdx.x / 8 + 1][threadIdx.x % 8] = 1;
    out[threadIdx.x] = 1;
}

// [clean] the right row
__global__ void right_row(int* out) {
    __shared__ int tile[8][8];
    tile[threadIdx.x / 8][threadIdx.x % 8] = 1;
    out[threadIdx.x] = tile[threadIdx.x / 8][threadIdx.x % 8];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(into_neighbour<<<1, 64>>>(out));
    RUN(inside<<<1, 64>>>(out));
    RUN(dynamic_small<<<1, 64, 63 * sizeof(int)>>>(out));
    RUN(dynamic_right<<<1, 64, 64 * sizeof(int)>>>(out));
    RUN(before_begin<<<1, 64>>>(out));
    RUN(row_too_many<<<1, 64>>>(out));
    RUN(right_row<<<1, 64>>>(out));
    cudaFree(out);
}
