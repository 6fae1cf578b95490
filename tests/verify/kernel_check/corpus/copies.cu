// Records and arrays that are copied whole: memcpy, memset, assignments of any size.
#include <algorithm>

#include "corpus.h"

struct Twelve {
    float x, y, z;
};
struct Big {
    int values[12];
};

// [data race] records of 12 bytes
__global__ void twelve(Twelve* a) { a[threadIdx.x] = a[(threadIdx.x + 1) % 32]; }

// [clean] each its own
__global__ void twelve_own(Twelve* a) {
    const Twelve t = a[threadIdx.x];
    a[threadIdx.x] = t;
}

// [data race] records of 48 bytes
__global__ void big(Big* a) { a[threadIdx.x / 2] = a[threadIdx.x]; }

// [clean] apart
__global__ void big_apart(const Big* a, Big* b) { b[threadIdx.x] = a[threadIdx.x / 2]; }

// [same-value race] memcpy over a neighbour's part
__global__ void copy_over(char* a) { memcpy(a + threadIdx.x * 7, a + 512, 8); }

// [clean] just to its end
__global__ void copy_up_to(char* a) { memcpy(a + threadIdx.x * 7, a + 512, 7); }

// [data race] memset of a neighbour's part
__global__ void set_over(int* s) {
    __shared__ int t[128];
    memset(t + threadIdx.x * 2, 0, 12);
    s[threadIdx.x] = t[threadIdx.x * 2];
}

// [out of bounds] memcpy beyond the end
__global__ void copy_beyond(char* a) { memcpy(a + 1024 - 20, a, 24); }

// [clean] std::copy inside
__global__ void standard_copy(const int* a, int* b) {
    std::copy(a + threadIdx.x * 3, a + threadIdx.x * 3 + 3, b + threadIdx.x * 3);
}

// [data race] std::copy that overlaps
__global__ void standard_copy_over(int* b) {
    std::copy(b + threadIdx.x * 3, b + threadIdx.x * 3 + 4, b + 96 + threadIdx.x * 3);
}

// [main]
int main() {
    Twelve* t = zeros<Twelve>(32);
    Big* b = zeros<Big>(64);
    char* c = zeros<char>(1024);
    int* i = zeros<int>(256);
    int* j = zeros<int>(256);
    RUN(twelve<<<1, 32>>>(t));
    RUN(twelve_own<<<1, 32>>>(t));
    RUN(big<<<1, 32>>>(b));
    RUN(big_apart<<<1, 32>>>(b, b + 32));
    RUN(copy_over<<<1, 32>>>(c));
    RUN(copy_up_to<<<1, 32>>>(c));
    RUN(set_over<<<1, 32>>>(i));
    RUN(copy_beyond<<<1, 1>>>(c));
    RUN(standard_copy<<<1, 32>>>(i, j));
    RUN(standard_copy_over<<<1, 32>>>(j));
    cudaFree(t);
    cudaFree(b);
    cudaFree(c);
    cudaFree(i);
    cudaFree(j);
}
