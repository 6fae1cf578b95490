// Tiles of matrices and images in shared memory.
#include "corpus.h"

// [clean] a product of matrices, tile by tile
__global__ void product(const float* a, const float* b, float* c) {
    __shared__ float ta[8][8], tb[8][9];
    const int x = blockIdx.x * 8 + threadIdx.x, y = blockIdx.y * 8 + threadIdx.y;
    float sum = 0;
    for (int t = 0; t < 16; t += 8) {
        ta[threadIdx.y][threadIdx.x] = a[y * 16 + t + threadIdx.x];
        tb[threadIdx.y][threadIdx.x] = b[(t + threadIdx.y) * 16 + x];
        __syncthreads();
        for (int k = 0; k < 8; ++k) sum += ta[threadIdx.y][k] * tb[k][threadIdx.x];
        __syncthreads();
    }
    c[y * 16 + x] = sum;
}

// [data race] the second barrier is missing
__global__ void product_early(const float* a, const float* b, float* c) {
    __shared__ float ta[8][8], tb[8][9];
    const int x = blockIdx.x * 8 + threadIdx.x, y = blockIdx.y * 8 + threadIdx.y;
    float sum = 0;
    for (int t = 0; t < 16; t += 8) {
        ta[threadIdx.y][threadIdx.x] = a[y * 16 + t + threadIdx.x];
        tb[threadIdx.y][threadIdx.x] = b[(t + threadIdx.y) * 16 + x];
        __syncthreads();
        for (int k = 0; k < 8; ++k) sum += ta[threadIdx.y][k] * tb[k][threadIdx.x];
    }
    c[y * 16 + x] = sum;
}

// [clean] a transposition through a tile
__global__ void transpose(const float* a, float* b) {
    __shared__ float tile[8][9];
    tile[threadIdx.y][threadIdx.x] = a[threadIdx.y * 8 + threadIdx.x];
    __syncthreads();
    b[threadIdx.y * 8 + threadIdx.x] = tile[threadIdx.x][threadIdx.y];
}

// [data race] its barrier is missing
__global__ void transpose_early(const float* a, float* b) {
    __shared__ float tile[8][9];
    tile[threadIdx.y][threadIdx.x] = a[threadIdx.y * 8 + threadIdx.x];
    b[threadIdx.y * 8 + threadIdx.x] = tile[threadIdx.x][threadIdx.y];
}

// [main]
int main() {
    float* a = zeros<float>(256);
    float* b = zeros<float>(256);
    float* c = zeros<float>(256);
    RUN(product<<<dim3(2, 2), dim3(8, 8)>>>(a, b, c));
    RUN(product_early<<<dim3(2, 2), dim3(8, 8)>>>(a, b, c));
    RUN(transpose<<<1, dim3(8, 8)>>>(a, b));
    RUN(transpose_early<<<1, dim3(8, 8)>>>(a, b));
    cudaFree(a);
    cudaFree(b);
    cudaFree(c);
}
