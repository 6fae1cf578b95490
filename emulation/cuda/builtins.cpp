// threadIdx and its kin: plain variables of the program, which the scheduler sets before a thread
// goes on. One host thread runs all CUDA threads.
#include "emulation/cuda/include/scotty_cuda/interface.h"

namespace scotty_cuda {

namespace {

/// threadIdx, blockIdx, blockDim, gridDim.
constinit Dim* builtins[4] = {};

}  // namespace

void register_builtins(void* thread, void* block, void* block_size, void* grid_size) {
    builtins[0] = static_cast<Dim*>(thread);
    builtins[1] = static_cast<Dim*>(block);
    builtins[2] = static_cast<Dim*>(block_size);
    builtins[3] = static_cast<Dim*>(grid_size);
}

void show_place(const Dim& thread, const Dim& block) {
    *builtins[0] = thread;
    *builtins[1] = block;
}

void show_grid(const Dim& block, const Dim& grid) {
    *builtins[2] = block;
    *builtins[3] = grid;
}

bool is_builtin(const void* address) {
    const auto at = reinterpret_cast<uintptr_t>(address);
    for (const Dim* const builtin : builtins) {
        if (at - reinterpret_cast<uintptr_t>(builtin) < sizeof(Dim)) return true;
    }
    return false;
}

}  // namespace scotty_cuda
