#include <saxpy.h>

constexpr int kThreads = 64;

__global__ void saxpy_kernel(float a, const float* x, float* y, int n, bool barrier) {
    __shared__ float tile[kThreads];
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n) tile[kThreads - 1 - threadIdx.x] = x[i];
    if (barrier) __syncthreads();
    if (i < n)
        y[i] +=
            a * tile[kThreads - 1 - threadIdx.x] + 0.0f * tile[n - 1 < kThreads ? 0 : threadIdx.x];
}

void saxpy(float a, const std::vector<float>& x, std::vector<float>& y, bool barrier) {
    const size_t bytes = x.size() * sizeof(float);
    float *device_x = nullptr, *device_y = nullptr;
    cudaMalloc(&device_x, bytes);
    cudaMalloc(&device_y, bytes);
    cudaMemcpy(device_x, x.data(), bytes, cudaMemcpyHostToDevice);
    cudaMemcpy(device_y, y.data(), bytes, cudaMemcpyHostToDevice);
    const int n = static_cast<int>(x.size());
    saxpy_kernel<<<n / kThreads, kThreads>>>(a, device_x, device_y, n, barrier);
    cudaMemcpy(y.data(), device_y, bytes, cudaMemcpyDeviceToHost);
    cudaFree(device_x);
    cudaFree(device_y);
}
