/// What translated CUDA text and the executor say to each other. C++17 without containers, because
/// every kernel program includes it.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace scotty_cuda {

struct Dim {
    uint32_t x = 1;
    uint32_t y = 1;
    uint32_t z = 1;
};

/// A launch: its kernel's text, its line, its grid.
struct LaunchInfo {
    const char* kernel = "";
    Dim grid;
    Dim block;
    size_t dynamic_shared = 0;
    void* stream = nullptr;
    const void* place = nullptr;  ///< of the launch, in the program's text
};

/// Runs the grid; `thread(arguments)` is one thread. Errors are left for cudaGetLastError().
void launch(const LaunchInfo& info, void (*thread)(void* arguments), void* arguments);

enum class Barrier : int { plain, all, any, count };
/// __syncthreads and its kin: the result is that of the predicate over the block.
int barrier(Barrier kind, int predicate, const void* place);

enum class WarpOperation : uint8_t {
    sync,
    shuffle,
    shuffle_up,
    shuffle_down,
    shuffle_xor,
    ballot,
    any,
    all,
    match_any,
    match_all,
    add,
    min_signed,
    min_unsigned,
    max_signed,
    max_unsigned,
    bit_and,
    bit_or,
    bit_xor,
    active,
};
/// A collective of the lanes that the mask names. `parameter` is a lane or a distance, `width` that
/// of a shuffle's groups; `flag` gets what __match_all_sync says, and may be null.
uint64_t warp(WarpOperation operation, uint32_t mask, uint64_t value, uint32_t parameter,
              uint32_t width, int* flag, const void* place);

/// The threads for which an atomic or a fence holds.
enum class Scope : uint8_t { thread, block, device, system };
enum class Order : uint8_t { relaxed, acquire, release, acquire_release };
/// Called before an atomic; the caller then reads and writes by itself.
void atomic_begins(void* address, size_t bytes, bool reads, bool writes, Scope scope, Order order,
                   const void* place);
/// Called after it, with whether it has changed the word.
void atomic_ends(bool changed);
void fence(Scope scope, Order order);

/// A shared object of the running block, the same for all of its threads.
void* shared_object(const void* site, const char* name, size_t bytes, size_t alignment);
/// Shared memory whose size the launch gave.
void* dynamic_shared();
/// A return statement of a kernel.
void leave(const char* file, int line);

enum class Space : uint8_t { device, constant, managed };
void register_variable(void* variable, size_t bytes, const char* name, Space space);
struct Variable {
    Variable(const volatile void* variable, size_t bytes, const char* name, Space space) {
        register_variable(const_cast<void*>(variable), bytes, name, space);
    }
};

/// The loads of the running function were the copy of a record, whose members need not all have
/// been written.
void record_copied(const void* to, const void* from, size_t bytes, size_t alignment);

/// Whether loads and stores of the running thread are looked at.
void hear_accesses(bool heard);

/// Where the program keeps threadIdx, blockIdx, blockDim and gridDim.
void register_builtins(void* thread, void* block, void* block_size, void* grid_size);
/// Sets threadIdx and blockIdx, and blockDim and gridDim.
void show_place(const Dim& thread, const Dim& block);
void show_grid(const Dim& block, const Dim& grid);
bool is_builtin(const void* address);

/// Whether a CUDA thread runs: false in host code.
bool in_kernel();
uint64_t clock_now();
/// The running thread gives others its turn.
void give_way();
/// Ends the launch: the thread cannot go on.
[[noreturn]] void trap(const char* why, const void* place);
uint32_t lane_index();

}  // namespace scotty_cuda
