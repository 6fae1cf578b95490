/// Global memory of the virtual device: grows, never shrinks, and is not initialised.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace scotty::emulation {

template <class T>
class DeviceBuffer {
 public:
    /// At least `count` elements; what was in it is lost when it has to grow.
    void resize(std::size_t count) {
        if (count > capacity_) {
            memory_.reset();
            memory_ = std::unique_ptr<T[]>(new T[count]);
            capacity_ = count;
        }
        count_ = count;
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
    std::unique_ptr<T[]> memory_;
    std::size_t count_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace scotty::emulation
