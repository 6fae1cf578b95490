/// Stacks that switch: each CUDA thread runs on one of its own, and stops in the middle of a call.
#pragma once

#include <cstddef>
#include <vector>

#if !defined(__x86_64__)
#include <ucontext.h>
#endif

namespace scotty::emulation::cuda {

/// A stack, and where its owner stands while it does not run. Its lowest page is a guard.
struct Stack {
    std::byte* low = nullptr;
    std::byte* high = nullptr;
    void* pointer = nullptr;  ///< of the stopped owner
#if !defined(__x86_64__)
    ucontext_t context{};
#endif
    bool holds(const void* address) const {
        const auto* const at = static_cast<const std::byte*>(address);
        return at >= low && at < high;
    }
};

/// Bytes of a stack, its guard included: what a CUDA thread has as local memory is 512 KiB at most.
constexpr std::size_t kStackBytes = std::size_t{256} << 10;

/// Makes the next switch to the stack begin with `entry`, which never returns. What the stack held
/// is lost; nothing on it is destroyed.
void begin_on(Stack& stack, void (*entry)());
/// Stops here, to go on when somebody switches back to `from`.
void switch_stacks(Stack& from, Stack& to);

/// Stacks of one process, handed out and taken back.
class StackPool {
 public:
    /// Null where the system has no address space left.
    Stack* take();
    void give_back(Stack* stack) { free_.push_back(stack); }
    /// Whether the address is in a stack of the pool.
    bool holds(const void* address) const;

 private:
    struct Piece {
        std::byte* begin;
        std::byte* end;
    };
    std::vector<Stack*> free_;
    std::vector<Piece> pieces_;
};

}  // namespace scotty::emulation::cuda
