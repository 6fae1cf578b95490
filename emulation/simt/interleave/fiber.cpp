#include "emulation/simt/interleave/fiber.h"

#include <cstdint>
#include <cstring>
#include <utility>

namespace scotty::emulation::simt {

Fiber::Fiber() : stack_(std::make_unique<std::byte[]>(kStack)) {}

void Fiber::start(std::function<void()> body) {
    body_ = std::move(body);
    over_ = false;
    error_ = nullptr;
    kept_ = {};
    ::getcontext(&own_);
    own_.uc_stack.ss_sp = stack_.get();
    own_.uc_stack.ss_size = kStack;
    own_.uc_link = &caller_;
    // makecontext() passes ints, so the pointer is passed in halves.
    const auto self = reinterpret_cast<std::uintptr_t>(this);
    ::makecontext(&own_, reinterpret_cast<void (*)()>(&Fiber::enter), 2,
                  static_cast<unsigned>(self), static_cast<unsigned>(self >> 32));
}

void Fiber::enter(unsigned low, unsigned high) {
    const std::uintptr_t address = std::uintptr_t{high} << 32 | low;
    Fiber* self = nullptr;
    std::memcpy(&self, &address, sizeof self);
    try {
        self->body_();
    } catch (...) {
        self->error_ = std::current_exception();
    }
    self->over_ = true;
}

void Fiber::resume() {
    std::swap(context, kept_);
    ::swapcontext(&caller_, &own_);
    std::swap(context, kept_);
}

void Fiber::stand() { ::swapcontext(&own_, &caller_); }

}  // namespace scotty::emulation::simt
