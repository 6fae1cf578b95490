// Templates, functors, lambdas, defaults, functions in other namespaces.
#include "corpus.h"

namespace mine {
template <class T, int N>
__device__ T sum(const T (&values)[N]) {
    T total = 0;
    for (int i = 0; i < N; ++i) total += values[i];
    return total;
}
}  // namespace mine

// [clean] a template with shared memory of its parameter's size
template <class T, int N>
__global__ void sized(T* out) {
    __shared__ T s[N];
    s[threadIdx.x] = threadIdx.x;
    __syncthreads();
    out[threadIdx.x] = mine::sum(s);
}

// [data race] without the barrier
template <class T, int N>
__global__ void sized_early(T* out) {
    __shared__ T s[N];
    s[threadIdx.x] = threadIdx.x;
    out[threadIdx.x] = mine::sum(s);
}

// [clean] a functor as an argument
struct Twice {
    __device__ int operator()(int x) const { return 2 * x; }
};
template <class F>
__global__ void apply(int* a, F f) {
    a[threadIdx.x] = f(a[threadIdx.x]);
}

// [data race] a functor that meets others
struct Meets {
    int* place;
    __device__ int operator()(int x) const { return *place += x; }
};
template <class F>
__global__ void apply_meeting(int* a, F f) {
    a[threadIdx.x + 1] = f(threadIdx.x);
}

// [clean] a default argument
__global__ void defaulted(int* a, int value = 3) { a[threadIdx.x] = value; }

// [clean] early return inside a lambda is none of the kernel
__global__ void with_lambda(int* a) {
    auto f = [&](int i) {
        if (i < 3) return;
        a[i] = 1;
    };
    f(threadIdx.x);
    __syncthreads();
}

// [main]
int main() {
    int* a = zeros<int>(64);
    RUN(sized<int, 32><<<1, 32>>>(a));
    RUN(sized_early<int, 32><<<1, 32>>>(a));
    RUN(apply<<<1, 32>>>(a, Twice{}));
    RUN(apply_meeting<<<1, 32>>>(a, Meets{a}));
    RUN(defaulted<<<1, 32>>>(a));
    RUN(with_lambda<<<1, 32>>>(a));
    cudaFree(a);
}
