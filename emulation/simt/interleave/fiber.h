/// A function that can stand still in its middle and let its caller go on.
#pragma once

#include <ucontext.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>

#include "emulation/execution/context.h"

namespace scotty::emulation::simt {

/// Stays on the thread that made it. One that is given up half-way is not unwound: what it runs
/// must own nothing on its stack.
class Fiber {
 public:
    Fiber();
    Fiber(const Fiber&) = delete;
    Fiber& operator=(const Fiber&) = delete;

    /// `body` from its beginning, at the next resume().
    void start(std::function<void()> body);
    /// Returns when the body stands or is over.
    void resume();
    /// From inside the body.
    void stand();

    bool over() const { return over_; }
    /// What the body has thrown; null: nothing.
    std::exception_ptr error() const { return error_; }

 private:
    static void enter(unsigned low, unsigned high);
    static constexpr std::size_t kStack = std::size_t{256} << 10;

    std::unique_ptr<std::byte[]> stack_;
    std::function<void()> body_;
    ucontext_t own_{};
    ucontext_t caller_{};
    Context kept_{};  ///< of the CUDA thread that stands
    bool over_ = true;
    std::exception_ptr error_;
};

}  // namespace scotty::emulation::simt
