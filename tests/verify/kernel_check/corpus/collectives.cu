// Shuffles and votes, and who has to take part.
#include "corpus.h"

// [divergence] half of the lanes call a shuffle that names all, the others wait at a barrier
__global__ void half_shuffles(int* out) {
    int v = threadIdx.x;
    if (threadIdx.x < 16) {
        v = __shfl_sync(0xffffffff, v, 0);
    } else {
        __syncthreads();
    }
    out[threadIdx.x] = v;
}

// [clean] the mask names the half
__global__ void half_with_mask(int* out) {
    int v = threadIdx.x;
    if (threadIdx.x < 16) v = __shfl_sync(0x0000ffff, v, 0);
    __syncthreads();
    out[threadIdx.x] = v;
}

// [divergence] a lane calls with a mask that it is not in
__global__ void outside_mask(int* out) {
    out[threadIdx.x] = __shfl_sync(0x0000ffff, threadIdx.x, 0);
}

// [clean] all kinds of shuffles
__global__ void shuffles(int* out) {
    int v = threadIdx.x;
    v += __shfl_up_sync(0xffffffff, v, 1);
    v += __shfl_down_sync(0xffffffff, v, 1, 16);
    v += __shfl_xor_sync(0xffffffff, v, 3);
    const double d = __shfl_sync(0xffffffff, 0.5 * v, 2);
    out[threadIdx.x] = static_cast<int>(d);
}

// [clean] votes, matches and reductions
__global__ void votes(int* out) {
    const int any = __any_sync(0xffffffff, threadIdx.x == 3);
    const int all = __all_sync(0xffffffff, threadIdx.x < 32);
    const unsigned ballot = __ballot_sync(0xffffffff, threadIdx.x % 2);
    const unsigned same = __match_any_sync(0xffffffff, threadIdx.x / 8);
    int equal = 0;
    __match_all_sync(0xffffffff, 5, &equal);
    const unsigned sum = __reduce_add_sync(0xffffffff, threadIdx.x);
    if (any != 1 || all != 1 || ballot != 0xaaaaaaaau || equal != 1 || sum != 496u) __trap();
    if (__popc(same) != 8) __trap();
    out[threadIdx.x] = any;
}

// [divergence] lanes vote in one branch and shuffle in the other
__global__ void vote_or_shuffle(int* out) {
    if (threadIdx.x % 2 == 0) {
        out[threadIdx.x] = __any_sync(0xffffffff, 1);
    } else {
        out[threadIdx.x] = __shfl_sync(0xffffffff, 1, 0);
    }
}

// [clean] lanes that have returned are not waited for
__global__ void some_have_left(int* out) {
    if (threadIdx.x >= 20) return;
    out[threadIdx.x] = __any_sync(0xffffffff, threadIdx.x == 3);
}

// [clean] those who are here, by __activemask
__global__ void active(int* out) {
    if (threadIdx.x % 4 == 0) {
        const unsigned mask = __activemask();
        out[threadIdx.x] = __popc(__ballot_sync(mask, 1));
    }
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(half_shuffles<<<1, 32>>>(out));
    RUN(half_with_mask<<<1, 32>>>(out));
    RUN(outside_mask<<<1, 32>>>(out));
    RUN(shuffles<<<1, 32>>>(out));
    RUN(votes<<<1, 32>>>(out));
    RUN(vote_or_shuffle<<<1, 32>>>(out));
    RUN(some_have_left<<<1, 32>>>(out));
    RUN(active<<<1, 32>>>(out));
    cudaFree(out);
}
