/// Global memory of the virtual device: grows, never shrinks, and is not initialised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "emulation/device/device.h"
#include "emulation/device/watch.h"
#include "reference/base/memory.h"

namespace scotty::emulation {

/// The host writes through fill() and generate(), so that the checked build knows what is written.
template <class T>
class DeviceBuffer {
 public:
    DeviceBuffer() = default;  ///< of no device, and unwatched
    /// `device` outlives it; reports use `name`. In a buffer of `each_slot_once` a slot is written
    /// at most once between two calls of discard().
    DeviceBuffer(Device& device, const char* name, BufferUse use = BufferUse::any)
        : watch_(&device.watch()), name_(name), use_(use) {}

    /// Makes room for at least `count` elements; growing loses the content.
    void resize(std::size_t count) {
        if (count > capacity_) {
            if (count * sizeof(T) >= kLarge) {
                reference::require_memory(count * sizeof(T),
                                          std::string("the buffer of ") + name_ + " (" +
                                              std::to_string(count) + " of " +
                                              std::to_string(sizeof(T)) + " bytes)",
                                          "fewer --batch-rays or a smaller image need less");
            }
            memory_.reset();
            memory_ = WatchedMemory<T>::allocate(watch_, count, name_, use_);
            capacity_ = count;
        }
        count_ = count;
    }
    /// From here on the content is no longer needed.
    void discard() { WatchedMemory<T>::discard(watch_, memory_.get(), count_, use_); }
    void fill(const T& value) {
        generate([&](std::size_t) { return value; });
    }
    /// Sets element i to value(i).
    template <class Value>
    void generate(const Value& value) {
        for (std::size_t i = 0; i < count_; ++i) memory_[i] = value(i);
        WatchedMemory<T>::host_wrote(watch_, memory_.get(), count_);
    }

    /// Takes the size and the content of `values`.
    void assign(std::span<const T> values) {
        resize(values.size());
        generate([&](std::size_t i) { return values[i]; });
    }

    T* data() { return memory_.get(); }
    const T* data() const { return memory_.get(); }
    std::size_t size() const { return count_; }
    std::size_t bytes() const { return capacity_ * sizeof(T); }
    T& operator[](std::size_t index) { return memory_[index]; }
    const T& operator[](std::size_t index) const { return memory_[index]; }
    std::span<const T> view() const { return {memory_.get(), count_}; }
    std::span<T> span() { return {memory_.get(), count_}; }

 private:
    Watch* watch_ = nullptr;
    const char* name_ = "";
    BufferUse use_ = BufferUse::any;
    /// From this many bytes on, the system is asked first whether it has them.
    static constexpr std::size_t kLarge = std::size_t{1} << 24;

    typename WatchedMemory<T>::Pointer memory_;
    std::size_t count_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace scotty::emulation
