// Cooperative groups.
#include <cooperative_groups.h>

#include "corpus.h"

namespace cg = cooperative_groups;

// [clean] a block's barrier
__global__ void block_sync(int* out) {
    __shared__ int s[64];
    cg::thread_block block = cg::this_thread_block();
    s[block.thread_rank()] = 1;
    block.sync();
    out[block.thread_rank()] = s[63 - block.thread_rank()];
}

// [data race] a tile's barrier where the block's is needed
__global__ void tile_sync(int* out) {
    __shared__ int s[64];
    cg::thread_block block = cg::this_thread_block();
    auto tile = cg::tiled_partition<32>(block);
    s[block.thread_rank()] = 1;
    tile.sync();
    out[block.thread_rank()] = s[63 - block.thread_rank()];
}

// [clean] a tile's barrier for the tile's memory
__global__ void tile_memory(int* out) {
    __shared__ int s[64];
    auto tile = cg::tiled_partition<16>(cg::this_thread_block());
    s[threadIdx.x] = tile.thread_rank();
    tile.sync();
    out[threadIdx.x] = s[threadIdx.x / 16 * 16 + 15 - tile.thread_rank()];
}

// [data race] tiles that are too small
__global__ void small_tiles(int* out) {
    __shared__ int s[64];
    auto tile = cg::tiled_partition<8>(cg::this_thread_block());
    s[threadIdx.x] = tile.thread_rank();
    tile.sync();
    out[threadIdx.x] = s[threadIdx.x / 16 * 16 + 15 - threadIdx.x % 16];
}

// [clean] the lanes that are here count as one
__global__ void aggregated(int* count) {
    if (threadIdx.x % 3 == 0) {
        cg::coalesced_group here = cg::coalesced_threads();
        if (here.thread_rank() == 0) atomicAdd(count, here.size());
    }
}

// [divergence] half of a tile calls its shuffle
__global__ void half_tile(int* out) {
    auto tile = cg::tiled_partition<32>(cg::this_thread_block());
    if (threadIdx.x < 16) {
        out[threadIdx.x] = tile.shfl(threadIdx.x, 0);
    } else {
        __syncthreads();
    }
}

// [main]
int main() {
    int* out = zeros<int>(64);
    RUN(block_sync<<<1, 64>>>(out));
    RUN(tile_sync<<<1, 64>>>(out));
    RUN(tile_memory<<<1, 64>>>(out));
    RUN(small_tiles<<<1, 64>>>(out));
    RUN(aggregated<<<1, 64>>>(out));
    RUN(half_tile<<<1, 32>>>(out));
    cudaFree(out);
}
