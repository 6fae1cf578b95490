// Threads of a block meet in device memory.
#include "corpus.h"

// [data race] a shift in place
__global__ void shift_in_place(int* a) { a[threadIdx.x] = a[threadIdx.x + 1]; }

// [clean] read, barrier, write
__global__ void shift(int* a) {
    const int v = a[threadIdx.x + 1];
    __syncthreads();
    a[threadIdx.x] = v;
}

// [data race] a transposition that swaps from both sides
__global__ void transpose_twice(int* a) {
    const int x = threadIdx.x, y = threadIdx.y;
    const int t = a[y * 8 + x];
    a[y * 8 + x] = a[x * 8 + y];
    a[x * 8 + y] = t;
}

// [clean] one side only
__global__ void transpose(int* a) {
    const int x = threadIdx.x, y = threadIdx.y;
    if (x >= y) return;
    const int t = a[y * 8 + x];
    a[y * 8 + x] = a[x * 8 + y];
    a[x * 8 + y] = t;
}

// [data race] all write their number into one place
__global__ void one_place(int* a) { a[0] = threadIdx.x; }

// [clean] one does
__global__ void one_writer(int* a) {
    if (threadIdx.x == 5) a[0] = threadIdx.x;
}

// [data race] positions are computed modulo something too small
__global__ void wrapped(int* a) { a[threadIdx.x % 32] = threadIdx.x; }

// [clean] of the right size
__global__ void unwrapped(int* a) { a[threadIdx.x % 64] = threadIdx.x; }

// [main]
int main() {
    int* a = zeros<int>(128);
    RUN(shift_in_place<<<1, 64>>>(a));
    RUN(shift<<<1, 64>>>(a));
    RUN(transpose_twice<<<1, dim3(8, 8)>>>(a));
    RUN(transpose<<<1, dim3(8, 8)>>>(a));
    RUN(one_place<<<1, 64>>>(a));
    RUN(one_writer<<<1, 64>>>(a));
    RUN(wrapped<<<1, 64>>>(a));
    RUN(unwrapped<<<1, 64>>>(a));
    cudaFree(a);
}
