/// Shared memory of one block: an object for each SCOTTY_SHARED that its threads reach.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "reference/base/error.h"

namespace scotty::emulation::simt {

/// Unwritten memory, shared and global, holds this: as a float -4.3e8, as an id out of any range.
constexpr unsigned char kPoisonByte = 0xcd;

/// The place of shared memory whose size the launch gives.
inline constexpr char kDynamicShared = 0;

/// In a file of its own, which is never checked: no thread of the kernel writes this.
void fill_with_poison(std::byte* memory, std::size_t bytes);

class SharedMemory {
 public:
    /// What a kernel may declare statically on every CUDA device.
    static constexpr std::size_t kMostDeclared = std::size_t{48} << 10;
    static constexpr std::size_t kMostObjects = 32;
    /// Between two objects is a gap, so that a step beyond one does not land in the next.
    static constexpr std::size_t kGap = 32;
    static constexpr std::size_t kMostAlignment = 128;
    static constexpr std::size_t kBytes = kMostDeclared + kMostObjects * (kGap + kMostAlignment);

    void reset() {
        declared_ = 0;
        used_ = 0;
        without_gaps_ = 0;
    }

    /// The object declared at `place`, the same for all threads of the block. It holds poison when
    /// the first thread reaches it.
    void* object(const void* place, const char* name, std::size_t bytes, std::size_t alignment) {
        for (std::size_t i = 0; i < declared_; ++i) {
            if (declarations_[i].place == place) return memory_ + declarations_[i].offset;
        }
        const auto aligned = [&](std::size_t at) {
            return (at + alignment - 1) / alignment * alignment;
        };
        const std::size_t offset = aligned(declared_ == 0 ? 0 : used_ + kGap);
        without_gaps_ = aligned(without_gaps_) + bytes;
        if (without_gaps_ > kMostDeclared || offset + bytes > kBytes ||
            declared_ == declarations_.size()) {
            throw reference::Error::internal("shared memory of " + std::to_string(without_gaps_) +
                                             " bytes in " + std::to_string(declared_ + 1) +
                                             " objects: a block has 48 KiB and 32 objects");
        }
        declarations_[declared_++] = {place, name, offset, bytes};
        used_ = offset + bytes;
        fill_with_poison(memory_ + offset, bytes);
        return memory_ + offset;
    }

    /// Null if the launch gave none.
    void* dynamic() {
        for (std::size_t i = 0; i < declared_; ++i) {
            if (declarations_[i].place == &kDynamicShared) return memory_ + declarations_[i].offset;
        }
        return nullptr;
    }

    const std::byte* memory() const { return memory_; }
    std::size_t used() const { return used_; }  ///< bytes given out
    /// Whether an offset in memory(), below used(), is between two objects.
    bool in_gap(std::size_t offset) const {
        const Declaration* const before = last_before(offset);
        return before != nullptr && offset >= before->offset + before->bytes;
    }
    /// Calls f(begin, end) for each gap, whole words only.
    template <class F>
    void each_gap(const F& f) const {
        for (std::size_t i = 1; i < declared_; ++i) {
            const Declaration& before = declarations_[i - 1];
            f((before.offset + before.bytes + 3) / 4 * 4, declarations_[i].offset / 4 * 4);
        }
    }
    /// "counts, byte 12", for an offset in memory().
    std::string name_at(std::size_t offset) const {
        const Declaration* const object = last_before(offset);
        if (object == nullptr || offset >= used_) {
            return "behind all of it, byte " + std::to_string(offset - used_);
        }
        const std::size_t inside = offset - object->offset;
        if (inside < object->bytes) {
            return std::string(object->name) + ", byte " + std::to_string(inside);
        }
        return std::to_string(inside - object->bytes) + " bytes behind the end of " + object->name +
               " (" + std::to_string(object->bytes) + " bytes)";
    }

 private:
    struct Declaration {
        const void* place;
        const char* name;
        std::size_t offset;
        std::size_t bytes;
    };
    const Declaration* last_before(std::size_t offset) const {
        std::size_t i = declared_;
        while (i > 1 && declarations_[i - 1].offset > offset) --i;
        return i == 0 ? nullptr : &declarations_[i - 1];
    }

    std::array<Declaration, kMostObjects> declarations_{};
    std::size_t declared_ = 0;
    std::size_t used_ = 0;
    std::size_t without_gaps_ = 0;  ///< bytes that a device would give out
    alignas(kMostAlignment) std::byte memory_[kBytes];
};

}  // namespace scotty::emulation::simt
