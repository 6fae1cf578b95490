// Memory after its end.
#include "corpus.h"

// [freed memory] a kernel uses what was freed
__global__ void use(int* a) { a[threadIdx.x] = 1; }
void use_after_free() {
    int* a = zeros<int>(32);
    cudaFree(a);
    use<<<1, 32>>>(a);
}

// [clean] freed after its use
__global__ void use_first(int* a) { a[threadIdx.x] = 1; }
void free_after_use() {
    int* a = zeros<int>(32);
    use_first<<<1, 32>>>(a);
    cudaFree(a);
}

// [freed memory] freed twice
void free_twice() {
    int* a = zeros<int>(32);
    cudaFree(a);
    cudaFree(a);
}

// [clean] a null pointer may be freed
void free_null() { cudaFree(nullptr); }

// [freed memory] copied after its end
void copy_after_free() {
    int* a = zeros<int>(32);
    int host[32];
    cudaFree(a);
    cudaMemcpy(host, a, sizeof host, cudaMemcpyDeviceToHost);
}

// [freed memory] the kernel's own heap
__global__ void heap(int* out) {
    int* mine = new int[4];
    mine[0] = threadIdx.x;
    delete[] mine;
    out[threadIdx.x] = mine[0];
}

// [clean] likewise, in order
__global__ void heap_in_order(int* out) {
    int* mine = static_cast<int*>(malloc(16));
    mine[0] = threadIdx.x;
    out[threadIdx.x] = mine[0];
    free(mine);
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(use_after_free());
    RUN(free_after_use());
    RUN(free_twice());
    RUN(free_null());
    RUN(copy_after_free());
    RUN(heap<<<1, 32>>>(out));
    RUN(heap_in_order<<<1, 32>>>(out));
    cudaFree(out);
}
