// Records as arguments and results: their copies are part of the call.
#include "corpus.h"

struct Ray {
    float origin[3], direction[3];
    float t;
};
typedef struct {
    int first, second, third, fourth, fifth;
} Five;

__device__ float length(float4 v) { return v.x * v.x + v.y * v.y; }
__device__ float4 operator+(float4 a, float4 b) {
    return make_float4(a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w);
}
__device__ Ray ray_of(float t) {
    Ray ray = {{0, 0, 0}, {0, 0, 1}, t};
    return ray;
}
__device__ float end_of(Ray ray) { return ray.origin[2] + ray.t * ray.direction[2]; }
__device__ int sum_of(Five five) { return five.first + five.fifth; }

// [data race] a function gives what all store in one place
__global__ void give_vector(float4* a) { a[0] = make_float4(threadIdx.x, 1, 2, 3); }

// [clean] each has a place of its own
__global__ void give_vector_apart(float4* a) { a[threadIdx.x] = make_float4(threadIdx.x, 1, 2, 3); }

// [data race] the same for a record of 28 bytes
__global__ void give_record(Ray* a) { a[threadIdx.x / 2] = ray_of(threadIdx.x); }

// [clean] each its own
__global__ void give_record_apart(Ray* a) { a[threadIdx.x] = ray_of(threadIdx.x); }

// [data race] an argument is a neighbour's vector, and no barrier is before
__global__ void take_vector(float* out) {
    __shared__ float4 tile[64];
    tile[threadIdx.x] = make_float4(threadIdx.x, 1, 2, 3);
    out[threadIdx.x] = length(tile[63 - threadIdx.x]);
}

// [clean] a barrier is
__global__ void take_vector_behind_barrier(float* out) {
    __shared__ float4 tile[64];
    tile[threadIdx.x] = make_float4(threadIdx.x, 1, 2, 3);
    __syncthreads();
    out[threadIdx.x] = length(tile[63 - threadIdx.x]);
}

// [data race] an argument is a neighbour's record
__global__ void take_record(Ray* a, float* out) {
    a[threadIdx.x].t = 2;
    out[threadIdx.x] = end_of(a[63 - threadIdx.x]);
}

// [clean] an argument is the thread's own
__global__ void take_record_own(Ray* a, float* out) {
    a[threadIdx.x].t = 2;
    out[threadIdx.x] = end_of(a[threadIdx.x]);
}

// [data race] an operator takes neighbours
__global__ void add(float4* a) { a[threadIdx.x] = a[threadIdx.x] + a[(threadIdx.x + 1) % 64]; }

// [clean] and gives another array
__global__ void add_apart(const float4* a, float4* b) {
    b[threadIdx.x] = a[threadIdx.x] + a[(threadIdx.x + 1) % 64];
}

// [unwritten memory] no member of an argument was written
__global__ void take_unwritten(float* out) {
    __shared__ Five five;
    out[threadIdx.x] = sum_of(five);
}

// [clean] some members were, and all are copied
__global__ void take_partly_written(float* out) {
    __shared__ Five fives[64];
    fives[threadIdx.x].first = 1;
    fives[threadIdx.x].fifth = 2;
    out[threadIdx.x] = sum_of(fives[threadIdx.x]);
}

// [out of bounds] an argument behind the end
__global__ void take_beyond(const float4* a, float* out) { out[0] = length(a[64]); }

// [clean] the last one
__global__ void take_last(const float4* a, float* out) { out[0] = length(a[63]); }

// [main]
int main() {
    float4* a = zeros<float4>(64);
    float4* b = zeros<float4>(64);
    Ray* rays = zeros<Ray>(64);
    float* out = zeros<float>(64);
    RUN(give_vector<<<1, 64>>>(a));
    RUN(give_vector_apart<<<1, 64>>>(a));
    RUN(give_record<<<1, 64>>>(rays));
    RUN(give_record_apart<<<1, 64>>>(rays));
    RUN(take_vector<<<1, 64>>>(out));
    RUN(take_vector_behind_barrier<<<1, 64>>>(out));
    RUN(take_record<<<1, 64>>>(rays, out));
    RUN(take_record_own<<<1, 64>>>(rays, out));
    RUN(add<<<1, 64>>>(a));
    RUN(add_apart<<<1, 64>>>(a, b));
    RUN(take_unwritten<<<1, 1>>>(out));
    RUN(take_partly_written<<<1, 64>>>(out));
    RUN(take_beyond<<<1, 1>>>(a, out));
    RUN(take_last<<<1, 1>>>(a, out));
    cudaFree(a);
    cudaFree(b);
    cudaFree(rays);
    cudaFree(out);
}
