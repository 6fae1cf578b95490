// Accesses beyond allocations.
#include "corpus.h"

// [out of bounds] one element too far
__global__ void one_too_far(int* a, int n) { a[threadIdx.x + 1] = n; }

// [clean] the last thread does not
__global__ void not_too_far(int* a, int n) {
    if (threadIdx.x + 1 < n) a[threadIdx.x + 1] = n;
}

// [out of bounds] before the begin
__global__ void before_begin(int* a) { a[static_cast<int>(threadIdx.x) - 1] = 1; }

// [clean] from the begin on
__global__ void from_begin(int* a) { a[threadIdx.x] = 1; }

// [out of bounds] a null pointer
__global__ void null_pointer(int* a) { a[threadIdx.x] = 1; }

// [clean] which is looked at first
__global__ void null_pointer_checked(int* a) {
    if (a != nullptr) a[threadIdx.x] = 1;
}

// [out of bounds] no check of the last block's size
__global__ void last_block_unchecked(float* a, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    a[i] *= 2.0f;
}

// [clean] checked
__global__ void last_block_checked(float* a, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n) a[i] *= 2.0f;
}

// [out of bounds] eight bytes where four are left
__global__ void across_end(int* a, int n) { *reinterpret_cast<short4*>(a + n - 1) = {}; }

// [out of bounds] far away, into the next allocation
__global__ void far_away(int* a, int* b) { a[1000 + threadIdx.x] = b[0]; }

// [main]
int main() {
    int* a = zeros<int>(64);
    int* b = zeros<int>(64);
    float* f = zeros<float>(100);
    RUN(one_too_far<<<1, 64>>>(a, 64));
    RUN(not_too_far<<<1, 64>>>(a, 64));
    RUN(before_begin<<<1, 64>>>(b));
    RUN(from_begin<<<1, 64>>>(b));
    RUN(null_pointer<<<1, 64>>>(nullptr));
    RUN(null_pointer_checked<<<1, 64>>>(nullptr));
    RUN(last_block_unchecked<<<4, 32>>>(f, 100));
    RUN(last_block_checked<<<4, 32>>>(f, 100));
    RUN(across_end<<<1, 1>>>(a, 63));
    RUN(across_end<<<1, 1>>>(a, 64));
    RUN(far_away<<<1, 32>>>(a, b));
    cudaFree(a);
    cudaFree(b);
    cudaFree(f);
}
