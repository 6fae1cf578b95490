/// A function that can pause in its middle and let its caller go on.
#pragma once

#include <ucontext.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>

#include "emulation/execution/context.h"

namespace scotty::emulation::simt {

/// It stays on the thread that made it. A fiber that is abandoned half-way is not unwound: its body
/// must own nothing on its stack.
class Fiber {
 public:
    Fiber();
    Fiber(const Fiber&) = delete;
    Fiber& operator=(const Fiber&) = delete;

    /// Runs `body` from its beginning, at the next resume().
    void start(std::function<void()> body);
    /// Returns when the body pauses or is over.
    void resume();
    /// Pauses the body; called from inside it.
    void stand();

    bool over() const { return over_; }
    /// What the body has thrown, or null.
    std::exception_ptr error() const { return error_; }

 private:
    static void enter(unsigned low, unsigned high);
    static constexpr std::size_t kStack = std::size_t{256} << 10;

    std::unique_ptr<std::byte[]> stack_;
    std::function<void()> body_;
    ucontext_t own_{};
    ucontext_t caller_{};
    Context kept_{};  ///< of the CUDA thread that is paused
    bool over_ = true;
    std::exception_ptr error_;
};

}  // namespace scotty::emulation::simt
