// Rows of pitched memory, and launches by cudaLaunchKernel.
#include "corpus.h"

const int kRows = 8;
const int kColumns = 13;
char* pitched;
size_t pitch;

__device__ int* row(char* memory, size_t bytes, int number) {
    return (int*)(memory + number * bytes);
}

// [clean] each writes its row
__global__ void write_rows(char* memory, size_t bytes) {
    for (int x = 0; x < kColumns; ++x) row(memory, bytes, threadIdx.x)[x] = x;
}

// [out of bounds] one row more than there are
__global__ void row_beyond(char* memory, size_t bytes) { row(memory, bytes, kRows)[0] = 1; }

// [data race] the row below, too
__global__ void rows_overlap(char* memory, size_t bytes) {
    row(memory, bytes, threadIdx.x)[0] = threadIdx.x;
    row(memory, bytes, (threadIdx.x + 1) % kRows)[0] = threadIdx.x + 9;
}

// [clean] to the host and back
void copy_rows() {
    int host[kRows][kColumns] = {};
    cudaMemcpy2D(host, sizeof host[0], pitched, pitch, sizeof host[0], kRows,
                 cudaMemcpyDeviceToHost);
    if (host[kRows - 1][kColumns - 1] != kColumns - 1) exit(9);
    cudaMemset2D(pitched, pitch, 0, sizeof host[0], kRows);
    cudaMemcpy2D(host, sizeof host[0], pitched, pitch, sizeof host[0], kRows,
                 cudaMemcpyDeviceToHost);
    if (host[3][3] != 0) exit(9);
}

// [out of bounds] more rows than there are
void copy_rows_beyond() {
    static int host[kRows + 1][kColumns];
    cudaMemcpy2D(host, sizeof host[0], pitched, pitch, sizeof host[0], kRows + 1,
                 cudaMemcpyDeviceToHost);
}

// [data race] launched by the runtime's function
__global__ void sum(int* total, int what) { *total += what; }

// [clean] likewise
__global__ void sum_atomically(int* total, int what) { atomicAdd(total, what); }

// [main]
int main() {
    cudaMallocPitch(&pitched, &pitch, kColumns * sizeof(int), kRows);
    cudaMemset2D(pitched, pitch, 0, kColumns * sizeof(int), kRows);
    int* total = zeros<int>(1);
    RUN(write_rows<<<1, kRows>>>(pitched, pitch));
    RUN(copy_rows());
    RUN(row_beyond<<<1, 1>>>(pitched, pitch));
    RUN(rows_overlap<<<1, kRows>>>(pitched, pitch));
    RUN(copy_rows_beyond());
    int what = 3;
    void* arguments[] = {&total, &what};
    RUN(cudaLaunchKernel(sum, dim3(1), dim3(32), arguments, 0, 0));
    RUN(cudaLaunchKernel(sum_atomically, dim3(1), dim3(32), arguments, 0, 0));
    cudaFree(total);
    cudaFree(pitched);
}
