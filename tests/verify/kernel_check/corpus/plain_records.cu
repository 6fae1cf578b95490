// Programs whose records have to be plain (in unions, say): their copies are unseen.
#include <type_traits>

#include "corpus.h"

struct Corner {
    float x, y, z;
};
struct Edge {
    Corner from, to;
};
union Word {
    float4 all;
    float one[4];
};
static_assert(std::is_trivially_copyable<Word>::value, "it is");

// [data race] one member of a union, another of a neighbour
__global__ void through_union(Word* words) {
    words[threadIdx.x].one[0] = words[(threadIdx.x + 1) % 32].all.x;
}

// [clean] a union is copied
__global__ void copy_union(const Word* a, Word* b) {
    Word word = a[threadIdx.x];
    word.one[1] = 3;
    b[threadIdx.x] = word;
}

// [clean] numbers without brackets
__global__ void without_brackets(float* out) {
    Edge edge = {0, 0, 0, 1, 2, 3};
    auto [x, y, z] = edge.to;
    out[threadIdx.x] = x + y + z;
}

// [main]
int main() {
    Word* a = zeros<Word>(32);
    Word* b = zeros<Word>(32);
    float* out = zeros<float>(32);
    RUN(through_union<<<1, 32>>>(a));
    RUN(copy_union<<<1, 32>>>(a, b));
    RUN(without_brackets<<<1, 32>>>(out));
    cudaFree(a);
    cudaFree(b);
    cudaFree(out);
}
