/// The executor that a launch or a runtime call without a device argument means, and the outcome of
/// its last launch: the CUDA runtime's state, for one host thread.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "emulation/simt/executor.h"
#include "reference/base/error.h"

namespace scotty::emulation::simt {

/// Makes an executor the current one as long as it lives.
class CurrentDevice {
 public:
    explicit CurrentDevice(Executor& executor) : before_(std::exchange(current(), &executor)) {}
    ~CurrentDevice() { current() = before_; }
    CurrentDevice(const CurrentDevice&) = delete;
    CurrentDevice& operator=(const CurrentDevice&) = delete;

    /// Null where there is none.
    static Executor*& current() {
        static thread_local Executor* executor = nullptr;
        return executor;
    }
    /// The error of the last launch, empty if it had none. As in CUDA, the host learns of it when
    /// it asks, and every other call fails until then.
    static std::string& launch_failure() {
        static thread_local std::string failure;
        return failure;
    }

 private:
    Executor* before_;
};

inline void label_on_current_device(const void* memory, const char* name) {
    const Executor* executor = CurrentDevice::current();
    if (executor != nullptr && executor->checker() != nullptr) {
        executor->checker()->label(memory, name);
    }
}

inline void discard_on_current_device(const void* memory, std::size_t bytes) {
    const Executor* executor = CurrentDevice::current();
    if (executor != nullptr && executor->checker() != nullptr) {
        executor->checker()->discard(memory, bytes, true);
    }
}

/// SCOTTY_LAUNCH. All streams behave like the default one: a launch is over on return.
template <class Stream, class... Parameters, class... Arguments>
void launch_on_current_device(const char* name, const Grid& grid, const Stream&,
                              Kernel (*kernel)(Parameters...), Arguments&&... arguments) {
    std::string& failure = CurrentDevice::launch_failure();
    if (!failure.empty()) return;
    if (CurrentDevice::current() == nullptr) {
        failure = "kernel " + std::string(name) + ": no executor is current";
        return;
    }
    try {
        CurrentDevice::current()->launch(name, grid, kernel, std::forward<Arguments>(arguments)...);
    } catch (const reference::Error& error) {
        failure = error.what();
    }
}

}  // namespace scotty::emulation::simt
