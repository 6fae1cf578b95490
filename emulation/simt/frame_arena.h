/// Memory for one block's coroutine frames: from a bump pointer, back to lists by size.
///
/// One worker uses it, for one block at a time. reset() takes all of it back at once, so that an
/// aborted block needs no clean-up: a kernel's locals are trivially destructible.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace scotty::emulation::simt {

class FrameArena {
 public:
    void* allocate(std::size_t bytes) {
        const std::size_t lines = lines_of(bytes);
        if (lines < kClasses && free_[lines] != nullptr) [[likely]] {
            Free* frame = free_[lines];
            free_[lines] = frame->next;
            return frame;
        }
        return carve(lines * kLine);
    }
    void release(void* memory, std::size_t bytes) noexcept {
        const std::size_t lines = lines_of(bytes);
        if (lines >= kClasses) return;
        free_[lines] = ::new (memory) Free{free_[lines]};
    }
    void reset() {
        free_.fill(nullptr);
        chunk_ = 0;
        next_ = chunks_.empty() ? nullptr : chunks_[0].begin();
        end_ = chunks_.empty() ? nullptr : chunks_[0].end();
    }

 private:
    static constexpr std::size_t kLine = 64;
    static constexpr std::size_t kClasses = 64;
    static constexpr std::size_t kChunk = std::size_t{1} << 18;

    struct Free {
        Free* next;
    };
    struct Chunk {
        std::unique_ptr<std::byte[]> memory;
        std::size_t size;
        std::byte* begin() const {
            void* aligned = memory.get();
            std::size_t space = size + kLine;
            return static_cast<std::byte*>(std::align(kLine, size, aligned, space));
        }
        std::byte* end() const { return begin() + size; }
    };

    /// The size in cache lines is odd: frames an even number of lines apart would crowd the same
    /// few sets of the first-level cache.
    static constexpr std::size_t lines_of(std::size_t bytes) {
        return ((bytes + kLine - 1) / kLine) | 1u;
    }
    /// Kept out of line, so that the rest is inlined.
    [[gnu::noinline]] void* carve(std::size_t size) {
        if (static_cast<std::size_t>(end_ - next_) < size) add_chunk(size);
        std::byte* frame = next_;
        next_ += size;
        return frame;
    }
    void add_chunk(std::size_t size) {
        if (next_ != nullptr) ++chunk_;
        while (chunk_ < chunks_.size() && chunks_[chunk_].size < size) ++chunk_;
        if (chunk_ == chunks_.size()) {
            const std::size_t bytes = size < kChunk ? kChunk : size;
            chunks_.push_back({std::make_unique<std::byte[]>(bytes + kLine), bytes});
        }
        next_ = chunks_[chunk_].begin();
        end_ = chunks_[chunk_].end();
    }

    std::array<Free*, kClasses> free_{};
    std::vector<Chunk> chunks_;
    std::size_t chunk_ = 0;
    std::byte* next_ = nullptr;
    std::byte* end_ = nullptr;
};

}  // namespace scotty::emulation::simt
