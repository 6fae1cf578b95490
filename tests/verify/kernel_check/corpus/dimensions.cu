// Indices of two and three dimensions.
#include "corpus.h"

// [data race] y is forgotten
__global__ void forgot_y(int* a) { a[blockIdx.x * blockDim.x + threadIdx.x] = threadIdx.y; }

// [clean] with y
__global__ void with_y(int* a) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x;
    const int y = blockIdx.y * blockDim.y + threadIdx.y;
    a[y * gridDim.x * blockDim.x + x] = y;
}

// [data race] z counts too little
__global__ void flat_z(int* a) {
    a[(threadIdx.z * blockDim.x + threadIdx.y) * blockDim.x + threadIdx.x] = threadIdx.z;
}

// [clean] each of a cube its own
__global__ void cube(int* a) {
    a[(threadIdx.z * blockDim.y + threadIdx.y) * blockDim.x + threadIdx.x] = threadIdx.z;
}

// [data race] blocks of two dimensions, one of them forgotten
__global__ void forgot_block_y(int* a) { a[blockIdx.x] = blockIdx.y; }

// [clean] both
__global__ void both_blocks(int* a) { a[blockIdx.y * gridDim.x + blockIdx.x] = blockIdx.z; }

// [main]
int main() {
    int* a = zeros<int>(512);
    RUN(forgot_y<<<2, dim3(8, 4)>>>(a));
    RUN(with_y<<<dim3(2, 2), dim3(8, 4)>>>(a));
    RUN(flat_z<<<1, dim3(4, 6, 4)>>>(a));
    RUN(cube<<<1, dim3(4, 6, 4)>>>(a));
    RUN(forgot_block_y<<<dim3(2, 3), 1>>>(a));
    RUN(both_blocks<<<dim3(2, 3), 1>>>(a));
    cudaFree(a);
}
