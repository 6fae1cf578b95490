// Parts of a word.
#include "corpus.h"

// [clean] one byte for each thread
__global__ void byte_each(char* a) { a[threadIdx.x] = 1; }

// [data race] one byte for two threads
__global__ void byte_for_two(char* a) { a[threadIdx.x / 2] = threadIdx.x; }

// [clean] a short for each thread, in shared memory
__global__ void short_each(short* a) {
    __shared__ short s[32];
    s[threadIdx.x] = 1;
    a[threadIdx.x] = s[threadIdx.x];
}

// [data race] shorts that overlap words of others
__global__ void short_and_word(short* a) {
    if (threadIdx.x == 0) {
        *reinterpret_cast<int*>(a) = 1;
    } else {
        a[threadIdx.x] = 2;
    }
}

// [clean] a flag of type bool for each thread
__global__ void flags(bool* a) { a[threadIdx.x] = threadIdx.x % 2; }

// [data race] bits of one byte, set plainly
__global__ void bits(unsigned char* a) { a[threadIdx.x / 8] |= 1u << threadIdx.x % 8; }

// [main]
int main() {
    char* a = zeros<char>(64);
    short* s = zeros<short>(64);
    RUN(byte_each<<<1, 64>>>(a));
    RUN(byte_for_two<<<1, 64>>>(a));
    RUN(short_each<<<1, 32>>>(s));
    RUN(short_and_word<<<1, 2>>>(s));
    RUN(flags<<<1, 64>>>(reinterpret_cast<bool*>(a)));
    RUN(bits<<<1, 64>>>(reinterpret_cast<unsigned char*>(a)));
    cudaFree(a);
    cudaFree(s);
}
