// Addresses that are no multiple of what is loaded.
#include "corpus.h"

// [misaligned] a float4 at an odd float
__global__ void odd_float4(float* a) {
    *reinterpret_cast<float4*>(a + 1) = *reinterpret_cast<float4*>(a + 8);
}

// [clean] at a multiple of four
__global__ void even_float4(float* a) {
    *reinterpret_cast<float4*>(a + 4) = *reinterpret_cast<float4*>(a + 8);
}

// [misaligned] an int at an odd byte
__global__ void odd_int(char* a, int* out) { out[0] = *reinterpret_cast<int*>(a + 2); }

// [clean] put together from bytes
__global__ void bytes_to_int(char* a, int* out) { memcpy(out, a + 2, 4); }

// [main]
int main() {
    float* f = zeros<float>(64);
    char* c = zeros<char>(64);
    int* out = zeros<int>(1);
    RUN(odd_float4<<<1, 1>>>(f));
    RUN(even_float4<<<1, 1>>>(f));
    RUN(odd_int<<<1, 1>>>(c, out));
    RUN(bytes_to_int<<<1, 1>>>(c, out));
    cudaFree(f);
    cudaFree(c);
    cudaFree(out);
}
