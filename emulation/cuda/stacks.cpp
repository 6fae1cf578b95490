#include "emulation/cuda/stacks.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <memory>

namespace scotty::emulation::cuda {

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kStacksAtOnce = 256;

}  // namespace

#if defined(__x86_64__)

// Saves the registers that a call keeps, changes the stack pointer, and restores them. A jump in
// place of a return, because returns to another stack are predicted wrong every time (16 ns).
asm(R"(
    .text
    .type scotty_cuda_switch, @function
scotty_cuda_switch:
    pushq %rbp
    pushq %rbx
    pushq %r12
    pushq %r13
    pushq %r14
    pushq %r15
    movq %rsp, (%rdi)
    movq %rsi, %rsp
    popq %r15
    popq %r14
    popq %r13
    popq %r12
    popq %rbx
    popq %rbp
    popq %rcx
    jmp *%rcx
    .size scotty_cuda_switch, . - scotty_cuda_switch
)");
extern "C" void scotty_cuda_switch(void** from, void* to);

void begin_on(Stack& stack, void (*entry)()) {
    // Six registers, the address that the switch returns to, and a return address of nobody.
    auto** const top = reinterpret_cast<void**>(stack.high) - 8;
    std::fill_n(top, 8, nullptr);
    top[6] = reinterpret_cast<void*>(entry);
    stack.pointer = top;
}

void switch_stacks(Stack& from, Stack& to) { scotty_cuda_switch(&from.pointer, to.pointer); }

#else

void begin_on(Stack& stack, void (*entry)()) {
    ::getcontext(&stack.context);
    stack.context.uc_stack.ss_sp = stack.low;
    stack.context.uc_stack.ss_size = static_cast<std::size_t>(stack.high - stack.low);
    stack.context.uc_link = nullptr;
    ::makecontext(&stack.context, entry, 0);
}

void switch_stacks(Stack& from, Stack& to) { ::swapcontext(&from.context, &to.context); }

#endif

Stack* StackPool::take() {
    if (free_.empty()) {
        void* const mapped = ::mmap(nullptr, kStacksAtOnce * kStackBytes, PROT_READ | PROT_WRITE,
                                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK, -1, 0);
        if (mapped == MAP_FAILED) return nullptr;
        auto* const begin = static_cast<std::byte*>(mapped);
        pieces_.push_back({begin, begin + kStacksAtOnce * kStackBytes});
        for (std::size_t i = kStacksAtOnce; i-- > 0;) {
            std::byte* const low = begin + i * kStackBytes;
            ::mprotect(low, kPage, PROT_NONE);
            auto stack = std::make_unique<Stack>();
            stack->low = low + kPage;
            // Stacks that begin at equal distances would crowd the same sets of the caches.
            stack->high = low + kStackBytes - (i % 128) * 64 * 5;
            free_.push_back(stack.release());
        }
    }
    Stack* const stack = free_.back();
    free_.pop_back();
    return stack;
}

bool StackPool::holds(const void* address) const {
    const auto* const at = static_cast<const std::byte*>(address);
    return std::any_of(pieces_.begin(), pieces_.end(),
                       [at](const Piece& piece) { return at >= piece.begin && at < piece.end; });
}

}  // namespace scotty::emulation::cuda
