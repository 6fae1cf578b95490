// volatile keeps the compiler from remembering values, and orders nothing.
#include "corpus.h"

// [data race] a reduction of one warp through volatile memory
__global__ void volatile_reduction(int* out) {
    __shared__ volatile int s[64];
    s[threadIdx.x] = threadIdx.x;
    s[threadIdx.x + 32] = 0;
    for (int apart = 16; apart > 0; apart /= 2)
        s[threadIdx.x] = s[threadIdx.x] + s[threadIdx.x + apart];
    out[threadIdx.x] = s[0];
}

// [clean] with __syncwarp
__global__ void volatile_reduction_synchronised(int* out) {
    __shared__ volatile int s[64];
    s[threadIdx.x] = threadIdx.x;
    s[threadIdx.x + 32] = 0;
    __syncwarp();
    for (int apart = 16; apart > 0; apart /= 2) {
        const int v = s[threadIdx.x] + s[threadIdx.x + apart];
        __syncwarp();
        s[threadIdx.x] = v;
        __syncwarp();
    }
    out[threadIdx.x] = s[0];
}

// [data race] volatile writers of one place
__global__ void volatile_writers(volatile int* a) { *a = threadIdx.x; }

// [clean] each its own
__global__ void volatile_own(volatile int* a) { a[threadIdx.x] = a[threadIdx.x] + 1; }

// [main]
int main() {
    int* a = zeros<int>(64);
    RUN(volatile_reduction<<<1, 32>>>(a));
    RUN(volatile_reduction_synchronised<<<1, 32>>>(a));
    RUN(volatile_writers<<<1, 32>>>(a));
    RUN(volatile_own<<<1, 32>>>(a));
    cudaFree(a);
}
