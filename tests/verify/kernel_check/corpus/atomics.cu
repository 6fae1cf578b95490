// Atomic and plain accesses to one place.
#include "corpus.h"

// [data race] a plain read beside atomics
__global__ void read_beside(int* a, int* out) {
    atomicAdd(a, 1);
    out[threadIdx.x] = a[0];
}

// [clean] the read comes behind a barrier
__global__ void read_behind(int* a, int* out) {
    atomicAdd(a, 1);
    __syncthreads();
    out[threadIdx.x] = a[0];
}

// [data race] a plain write beside atomics
__global__ void write_beside(int* a) {
    if (threadIdx.x == 0) a[0] = 7;
    atomicMax(a, 3);
}

// [clean] an atomic write
__global__ void exchange_beside(int* a) {
    if (threadIdx.x == 0) atomicExch(a, 7);
    atomicMax(a, 3);
}

// [clean] each takes a slot of its own
__global__ void slots(int* count, int* out) { out[atomicAdd(count, 1)] = threadIdx.x; }

// [data race] the slot is read and then raised
__global__ void slots_plain(int* count, int* out) {
    const int slot = count[0];
    count[0] = slot + 1;
    out[slot] = threadIdx.x;
}

// [clean] all operations on integers
__global__ void operations(unsigned* a, unsigned long long* b, float* f) {
    atomicAdd(&a[0], 1u);
    atomicSub(&a[1], 1u);
    atomicMin(&a[2], threadIdx.x);
    atomicMax(&a[3], threadIdx.x);
    atomicAnd(&a[4], 1u);
    atomicOr(&a[5], 1u);
    atomicXor(&a[6], 1u);
    atomicInc(&a[7], 5u);
    atomicDec(&a[8], 5u);
    atomicExch(&a[9], 1u);
    atomicCAS(&a[10], 0u, 1u);
    atomicAdd(b, 1ull);
    atomicAdd(f, 0.5f);
}

// [data race] different halves of one number, one atomically
__global__ void halves(unsigned long long* a) {
    if (threadIdx.x == 0) {
        atomicAdd(a, 1ull);
    } else {
        reinterpret_cast<unsigned*>(a)[1] = threadIdx.x;
    }
}

// [main]
int main() {
    int* a = zeros<int>(64);
    int* out = zeros<int>(64);
    unsigned* u = zeros<unsigned>(16);
    unsigned long long* l = zeros<unsigned long long>(4);
    float* f = zeros<float>(4);
    RUN(read_beside<<<1, 32>>>(a, out));
    RUN(read_behind<<<1, 32>>>(a, out));
    RUN(write_beside<<<1, 32>>>(a));
    RUN(exchange_beside<<<1, 32>>>(a));
    cudaMemset(a, 0, 4);
    RUN(slots<<<1, 32>>>(a, out));
    cudaMemset(a, 0, 4);
    RUN(slots_plain<<<1, 32>>>(a, out));
    RUN(operations<<<2, 32>>>(u, l, f));
    RUN(halves<<<1, 2>>>(l));
    cudaFree(a);
    cudaFree(out);
    cudaFree(u);
    cudaFree(l);
    cudaFree(f);
}
