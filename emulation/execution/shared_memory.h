/// Shared memory of one block: an object for each SCOTTY_SHARED that its threads reach.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "reference/base/error.h"

namespace scotty::emulation::simt {

/// Unwritten memory, shared and global, holds this: as a float -4.3e8, as an id out of any range.
constexpr unsigned char kPoisonByte = 0xcd;

/// The place of shared memory whose size the launch gives.
inline constexpr char kDynamicShared = 0;

class SharedMemory {
 public:
    /// What a kernel may declare statically on every CUDA device.
    static constexpr std::size_t kBytes = std::size_t{48} << 10;

    void reset() {
        declared_ = 0;
        used_ = 0;
    }

    /// The object declared at `place`, the same for all threads of the block. It holds poison when
    /// the first thread reaches it.
    void* object(const void* place, const char* name, std::size_t bytes, std::size_t alignment) {
        for (std::size_t i = 0; i < declared_; ++i) {
            if (declarations_[i].place == place) return memory_ + declarations_[i].offset;
        }
        const std::size_t offset = (used_ + alignment - 1) / alignment * alignment;
        if (offset + bytes > kBytes || declared_ == declarations_.size()) {
            throw reference::Error::internal("shared memory of " + std::to_string(offset + bytes) +
                                             " bytes in " + std::to_string(declared_ + 1) +
                                             " objects: a block has 48 KiB and 32 objects");
        }
        declarations_[declared_++] = {place, name, offset};
        used_ = offset + bytes;
        std::memset(memory_ + offset, kPoisonByte, bytes);
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
    /// "counts, byte 12", for an offset in memory().
    std::string name_at(std::size_t offset) const {
        if (offset >= used_) return "behind all of it, byte " + std::to_string(offset - used_);
        std::size_t i = declared_;
        while (i > 1 && declarations_[i - 1].offset > offset) --i;
        return std::string(declarations_[i - 1].name) + ", byte " +
               std::to_string(offset - declarations_[i - 1].offset);
    }

 private:
    struct Declaration {
        const void* place;
        const char* name;
        std::size_t offset;
    };
    std::array<Declaration, 32> declarations_{};
    std::size_t declared_ = 0;
    std::size_t used_ = 0;
    alignas(128) std::byte memory_[kBytes];
};

}  // namespace scotty::emulation::simt
