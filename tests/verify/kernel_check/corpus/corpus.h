// What the programs of the corpus share: device memory with zeros in it, and a launch whose errors
// do not stop the next.
#pragma once

template <class T>
T* zeros(int count) {
    T* memory = nullptr;
    cudaMalloc(&memory, count * sizeof(T));
    cudaMemset(memory, 0, count * sizeof(T));
    return memory;
}

#define RUN(...)                 \
    do {                         \
        __VA_ARGS__;             \
        cudaDeviceSynchronize(); \
        cudaDeviceReset();       \
    } while (0)
