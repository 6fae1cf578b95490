// All write the same value to one place: a warning, and with --strict an error.
#include "corpus.h"

// [same-value race] a flag that says that something was found
__global__ void found(int* flag) { flag[0] = 1; }

// [clean] one lane sets it
__global__ void found_once(int* flag) {
    if (__any_sync(0xffffffff, threadIdx.x > 3) && threadIdx.x == 0) flag[0] = 1;
}

// [data race] some write another value
__global__ void found_what(int* flag) { flag[0] = threadIdx.x < 31 ? 1 : 2; }

// [same-value race] blocks clear the same array
__global__ void clear(int* a) { a[threadIdx.x] = 0; }

// [clean] each block its part
__global__ void clear_part(int* a) { a[blockIdx.x * blockDim.x + threadIdx.x] = 0; }

// [main]
int main() {
    int* a = zeros<int>(128);
    RUN(found<<<1, 32>>>(a));
    RUN(found_once<<<1, 32>>>(a));
    RUN(found_what<<<1, 32>>>(a));
    RUN(clear<<<2, 32>>>(a));
    RUN(clear_part<<<2, 32>>>(a));
    cudaFree(a);
}
