/// The coroutines that kernels and collective functions become.
///
/// Both start at once, on the caller's stack, and run to their first stop. One that never stops
/// costs an allocation from a list. Frames come from the block's arena.
#pragma once

#include <coroutine>
#include <cstddef>
#include <exception>
#include <type_traits>

#include "emulation/execution/context.h"
#include "emulation/simt/frame_arena.h"

namespace scotty::emulation::simt {

struct ArenaFrame {
    static void* operator new(std::size_t bytes) { return context.arena->allocate(bytes); }
    static void operator delete(void* memory, std::size_t bytes) noexcept {
        context.arena->release(memory, bytes);
    }
};

/// A kernel: one call is one CUDA thread. Only a launch may call it.
struct Kernel {
    struct promise_type : ArenaFrame {
        promise_type() { ++context.started; }
        Kernel get_return_object() const noexcept { return {}; }
        std::suspend_never initial_suspend() const noexcept { return {}; }
        /// The frame goes back to the arena; the thread's handle is not looked at again.
        std::suspend_never final_suspend() const noexcept { return {}; }
        void return_void() const noexcept {
            context.stop->site = &kLeft;
            ++context.finished;
        }
        [[noreturn]] void unhandled_exception() const { throw; }
    };
};

template <class T>
class Task;

/// The coroutine that waits for this one; null as long as none does.
struct Continuation : ArenaFrame {
    struct Final {
        bool await_ready() const noexcept { return false; }
        template <class Promise>
        std::coroutine_handle<> await_suspend(std::coroutine_handle<Promise> self) const noexcept {
            return self.promise().next;
        }
        void await_resume() const noexcept {}
    };
    std::suspend_never initial_suspend() const noexcept { return {}; }
    Final final_suspend() const noexcept { return {}; }
    [[noreturn]] void unhandled_exception() const { throw; }

    std::coroutine_handle<> next = std::noop_coroutine();
};

template <class T>
struct TaskPromise : Continuation {
    static_assert(std::is_trivially_destructible_v<T>);
    Task<T> get_return_object() noexcept;
    void return_value(const T& result) noexcept { value = result; }
    T value;
};
template <>
struct TaskPromise<void> : Continuation {
    Task<void> get_return_object() noexcept;
    void return_void() const noexcept {}
};

/// A running collective function. Its caller awaits it (SCOTTY_AWAIT); forgetting that is a
/// warning, and an error where the executor's targets are built.
template <class T>
class [[nodiscard]] Task {
 public:
    using promise_type = TaskPromise<T>;
    explicit Task(std::coroutine_handle<promise_type> handle) : handle_(handle) {}

    bool await_ready() const noexcept { return handle_.done(); }
    void await_suspend(std::coroutine_handle<> caller) const noexcept {
        handle_.promise().next = caller;
    }
    T await_resume() const {
        context.returns[context.thread] = nullptr;  // it was the function's, not the kernel's
        if constexpr (std::is_void_v<T>) {
            handle_.destroy();
        } else {
            const T result = handle_.promise().value;
            handle_.destroy();
            return result;
        }
    }

 private:
    std::coroutine_handle<promise_type> handle_;
};

template <class T>
Task<T> TaskPromise<T>::get_return_object() noexcept {
    return Task<T>(std::coroutine_handle<TaskPromise>::from_promise(*this));
}
inline Task<void> TaskPromise<void>::get_return_object() noexcept {
    return Task<void>(std::coroutine_handle<TaskPromise>::from_promise(*this));
}

}  // namespace scotty::emulation::simt
