// __device__, __constant__ and __managed__ variables.
#include "corpus.h"

__device__ int total;
__device__ int table[16] = {1, 2, 3}, copy[16];
__constant__ int factors[4] = {1, 2, 3, 4};
__managed__ int shared_with_host = 5;

// [data race] a variable of the device is raised plainly
__global__ void raise() { total += 1; }

// [clean] atomically
__global__ void raise_atomically() { atomicAdd(&total, 1); }

// [out of bounds] beyond an array of the device
__global__ void beyond_table(int* out) { out[threadIdx.x] = table[threadIdx.x]; }

// [clean] inside
__global__ void in_table(int* out) { out[threadIdx.x] = table[threadIdx.x % 16]; }

// [constant written] a constant is written
__global__ void write_constant() { const_cast<int*>(factors)[threadIdx.x % 4] = 1; }

// [clean] and read
__global__ void read_constant(int* out) { out[threadIdx.x] = factors[threadIdx.x % 4]; }

// [data race] a variable that the host sees
__global__ void managed_plain() { shared_with_host = threadIdx.x; }

// [clean] by one thread
__global__ void managed_one() {
    if (threadIdx.x == 0) shared_with_host = 3;
}

// [clean] copies to and from symbols
void symbols() {
    int values[16] = {};
    cudaMemcpyToSymbol(copy, values, sizeof values);
    cudaMemcpyFromSymbol(values, table, sizeof values);
    int* address = nullptr;
    cudaGetSymbolAddress(&address, copy);
    cudaMemset(address, 0, sizeof values);
    if (values[2] != 3) exit(9);
}

// [out of bounds] a copy larger than its symbol
void symbol_too_small() {
    int values[20] = {};
    cudaMemcpyToSymbol(copy, values, sizeof values);
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(raise<<<1, 32>>>());
    RUN(raise_atomically<<<1, 32>>>());
    RUN(beyond_table<<<1, 17>>>(out));
    RUN(in_table<<<1, 32>>>(out));
    RUN(write_constant<<<1, 4>>>());
    RUN(read_constant<<<1, 32>>>(out));
    RUN(managed_plain<<<1, 32>>>());
    RUN(managed_one<<<1, 32>>>());
    RUN(symbols());
    RUN(symbol_too_small());
    cudaFree(out);
    return shared_with_host == 3 ? 0 : 1;
}
