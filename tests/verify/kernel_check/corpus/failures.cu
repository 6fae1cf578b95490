// Kernels that fail by themselves.
#include "corpus.h"

// [assertion failed] an assertion
__global__ void asserts(int n) { assert(threadIdx.x < n); }

// [clean] one that holds
__global__ void asserts_right(int n) { assert(threadIdx.x < n); }

// [kernel failed] __trap()
__global__ void traps() {
    if (threadIdx.x == 3) __trap();
}

// [clean] printf
__global__ void prints() {
    if (threadIdx.x == 3) printf("thread %d\n", threadIdx.x);
}

// [kernel failed] a division by zero
__global__ void divides(int* a, int n) { a[0] = 7 / n; }

// [clean] by one
__global__ void divides_by_one(int* a, int n) { a[0] = 7 / n; }

// [main]
int main() {
    int* a = zeros<int>(1);
    RUN(asserts<<<1, 32>>>(31));
    RUN(asserts_right<<<1, 32>>>(32));
    RUN(traps<<<1, 32>>>());
    RUN(prints<<<1, 32>>>());
    RUN(divides<<<1, 1>>>(a, 0));
    RUN(divides_by_one<<<1, 1>>>(a, 1));
    cudaFree(a);
}
