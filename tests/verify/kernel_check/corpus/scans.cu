// Prefix sums.
#include "corpus.h"

// [data race] Hillis and Steele's scan in one array, with one barrier
__global__ void in_place_once(int* out) {
    __shared__ int s[64];
    const int i = threadIdx.x;
    s[i] = 1;
    __syncthreads();
    for (int d = 1; d < 64; d *= 2) {
        if (i >= d) s[i] += s[i - d];
        __syncthreads();
    }
    out[i] = s[i];
}

// [clean] with a barrier between reads and writes
__global__ void in_place(int* out) {
    __shared__ int s[64];
    const int i = threadIdx.x;
    s[i] = 1;
    __syncthreads();
    for (int d = 1; d < 64; d *= 2) {
        const int v = i >= d ? s[i - d] : 0;
        __syncthreads();
        s[i] += v;
        __syncthreads();
    }
    out[i] = s[i];
}

// [clean] with two arrays in turn, one barrier is enough
__global__ void double_buffer(int* out) {
    __shared__ int s[2][64];
    const int i = threadIdx.x;
    int from = 0;
    s[0][i] = 1;
    __syncthreads();
    for (int d = 1; d < 64; d *= 2) {
        s[1 - from][i] = s[from][i] + (i >= d ? s[from][i - d] : 0);
        from = 1 - from;
        __syncthreads();
    }
    out[i] = s[from][i];
}

// [data race] two arrays, but the barrier is forgotten
__global__ void double_buffer_without(int* out) {
    __shared__ int s[2][64];
    const int i = threadIdx.x;
    int from = 0;
    s[0][i] = 1;
    __syncthreads();
    for (int d = 1; d < 64; d *= 2) {
        s[1 - from][i] = s[from][i] + (i >= d ? s[from][i - d] : 0);
        from = 1 - from;
    }
    __syncthreads();
    out[i] = s[from][i];
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(in_place_once<<<1, 64>>>(out));
    RUN(in_place<<<1, 64>>>(out));
    RUN(double_buffer<<<1, 64>>>(out));
    RUN(double_buffer_without<<<1, 64>>>(out));
    cudaFree(out);
}
