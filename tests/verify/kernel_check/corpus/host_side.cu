// What the host does with device memory, and the device with the host's.
#include "corpus.h"

int host_value = 3;

// [device memory on the host] the host follows a device pointer
void host_reads() {
    int* a = zeros<int>(8);
    host_value = a[3];
    cudaFree(a);
}

// [clean] managed memory is for both
__global__ void managed(int* a) { a[threadIdx.x] += 1; }
void host_reads_managed() {
    int* a = nullptr;
    cudaMallocManaged(&a, 32 * sizeof(int));
    for (int i = 0; i < 32; ++i) a[i] = i;
    managed<<<1, 32>>>(a);
    cudaDeviceSynchronize();
    host_value = a[3];
    cudaFree(a);
}

// [host memory in a kernel] a kernel gets a pointer from new
__global__ void host_pointer(int* a) { a[threadIdx.x] = 1; }
void gives_host_pointer() {
    int* a = new int[32];
    host_pointer<<<1, 32>>>(a);
    delete[] a;
}

// [clean] pinned memory is for both
__global__ void pinned_pointer(int* a) { a[threadIdx.x] = 1; }
void gives_pinned() {
    int* a = nullptr;
    cudaMallocHost(&a, 32 * sizeof(int));
    pinned_pointer<<<1, 32>>>(a);
    cudaFreeHost(a);
}

// [wrong call] the wrong direction
void wrong_direction() {
    int* a = zeros<int>(8);
    int host[8];
    cudaMemcpy(host, a, sizeof host, cudaMemcpyHostToDevice);
    cudaFree(a);
}

// [clean] the right one
void right_direction() {
    int* a = zeros<int>(8);
    int host[8];
    cudaMemcpy(host, a, sizeof host, cudaMemcpyDeviceToHost);
    cudaFree(a);
}

// [out of bounds] a copy of more than there is
void copies_too_much() {
    int* a = zeros<int>(8);
    int host[16];
    cudaMemcpy(host, a, sizeof host, cudaMemcpyDeviceToHost);
    cudaFree(a);
}

// [wrong call] a pointer into an allocation is freed
void frees_inside() {
    int* a = zeros<int>(8);
    cudaFree(a + 1);
    cudaDeviceReset();
    cudaFree(a);
}

// [leak] memory is never freed
void leaks() {
    int* a = nullptr;
    cudaMalloc(&a, 128);
}

// [main]
int main() {
    RUN(host_reads());
    RUN(host_reads_managed());
    RUN(gives_host_pointer());
    RUN(gives_pinned());
    RUN(wrong_direction());
    RUN(right_direction());
    RUN(copies_too_much());
    RUN(frees_inside());
    RUN(leaks());
}
