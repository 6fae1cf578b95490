__global__ void racy(int* sum) { *sum += threadIdx.x; }

int main() {
    int* sum = nullptr;
    cudaMalloc(&sum, sizeof(int));
    cudaMemset(sum, 0, sizeof(int));
    racy<<<1, 64>>>(sum);
    cudaFree(sum);
}
