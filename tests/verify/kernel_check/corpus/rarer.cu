// What programs use now and then: cuda::atomic, clocks, naps, loads and stores with hints for the
// caches.
#include <cuda/atomic>

#include "corpus.h"

typedef cuda::atomic<int, cuda::thread_scope_device> Counter;

// [clean] a counter that is an atomic
__global__ void count(Counter* counter) { counter->fetch_add(1, cuda::memory_order_relaxed); }

// [clean] data behind a flag that is released and acquired
__global__ void pass(Counter* flag, int* data) {
    if (blockIdx.x == 0) {
        *data = 7;
        flag->store(1, cuda::memory_order_release);
    } else {
        while (flag->load(cuda::memory_order_acquire) == 0) __nanosleep(100);
        data[1] = *data;
    }
}

// [data race] the same, relaxed
__global__ void pass_relaxed(Counter* flag, int* data) {
    if (blockIdx.x == 0) {
        *data = 7;
        flag->store(1, cuda::memory_order_relaxed);
    } else {
        while (flag->load(cuda::memory_order_relaxed) == 0) __nanosleep(100);
        data[1] = *data;
    }
}

// [clean] a clock runs on
__global__ void wait_a_while(int* data) {
    const long long until = clock64() + 1000;
    while (clock64() < until) __nanosleep(20);
    data[threadIdx.x] = 1;
}

// [data race] hints change nothing
__global__ void hinted(int* data) {
    __stcg(data + threadIdx.x, __ldcg(data + (threadIdx.x + 1) % 32));
}

// [clean] apart
__global__ void hinted_apart(const int* a, int* b) {
    __stcs(b + threadIdx.x,
           __ldcs(a + (threadIdx.x + 1) % 32) + __ldca(a) + __ldlu(a + 1) + __ldcv(a + 2));
}

// [out of bounds] __ldg behind the end
__global__ void hinted_beyond(const int* a, int* b) { b[threadIdx.x] = __ldg(a + threadIdx.x + 1); }

// [main]
int main() {
    Counter* counter = zeros<Counter>(1);
    int* a = zeros<int>(32);
    int* b = zeros<int>(32);
    RUN(count<<<2, 32>>>(counter));
    cudaMemset(counter, 0, sizeof(Counter));
    RUN(pass<<<2, 1>>>(counter, a));
    cudaMemset(counter, 0, sizeof(Counter));
    RUN(pass_relaxed<<<2, 1>>>(counter, a));
    RUN(wait_a_while<<<1, 32>>>(a));
    RUN(hinted<<<1, 32>>>(a));
    RUN(hinted_apart<<<1, 32>>>(a, b));
    RUN(hinted_beyond<<<1, 32>>>(a, b));
    cudaFree(counter);
    cudaFree(a);
    cudaFree(b);
}
