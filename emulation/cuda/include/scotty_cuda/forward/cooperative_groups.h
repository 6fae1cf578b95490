/// Cooperative groups of a block: the block, its tiles, and coalesced threads.
// NOLINTBEGIN
#pragma once

#include "scotty_cuda/cuda.h"

namespace cooperative_groups {

struct thread_block {
    SCOTTY_CALL void sync() const {
        scotty_cuda::barrier(scotty_cuda::Barrier::plain, 0, SCOTTY_HERE);
    }
    SCOTTY_CALL static unsigned thread_rank() {
        return (threadIdx.z * blockDim.y + threadIdx.y) * blockDim.x + threadIdx.x;
    }
    static unsigned size() { return blockDim.x * blockDim.y * blockDim.z; }
    static unsigned num_threads() { return size(); }
    static dim3 group_index() { return dim3(blockIdx.x, blockIdx.y, blockIdx.z); }
    static dim3 thread_index() { return dim3(threadIdx.x, threadIdx.y, threadIdx.z); }
    static dim3 group_dim() { return blockDim; }
    static dim3 dim_threads() { return blockDim; }
};
inline thread_block this_thread_block() { return {}; }

/// Some lanes of a warp, by their mask; ranks count the lanes of the mask.
class lanes_group {
 public:
    explicit lanes_group(unsigned mask, unsigned meta_rank = 0, unsigned meta_size = 1)
        : mask_(mask), meta_rank_(meta_rank), meta_size_(meta_size) {}

    SCOTTY_CALL void sync() const {
        scotty_cuda::warp(scotty_cuda::WarpOperation::sync, mask_, 0, 0, 32, nullptr, SCOTTY_HERE);
    }
    unsigned size() const { return static_cast<unsigned>(__builtin_popcount(mask_)); }
    unsigned num_threads() const { return size(); }
    unsigned thread_rank() const {
        return static_cast<unsigned>(
            __builtin_popcount(mask_ & ((1u << scotty_cuda::lane_index()) - 1u)));
    }
    unsigned meta_group_rank() const { return meta_rank_; }
    unsigned meta_group_size() const { return meta_size_; }
    template <class T>
    SCOTTY_CALL T shfl(T value, unsigned rank) const {
        return shuffle(value, lane_of(rank), SCOTTY_HERE);
    }
    template <class T>
    SCOTTY_CALL T shfl_down(T value, unsigned delta) const {
        const unsigned rank = thread_rank() + delta;
        return shuffle(value, rank < size() ? lane_of(rank) : scotty_cuda::lane_index(),
                       SCOTTY_HERE);
    }
    template <class T>
    SCOTTY_CALL T shfl_up(T value, unsigned delta) const {
        const unsigned rank = thread_rank();
        return shuffle(value, rank >= delta ? lane_of(rank - delta) : scotty_cuda::lane_index(),
                       SCOTTY_HERE);
    }
    template <class T>
    SCOTTY_CALL T shfl_xor(T value, unsigned lanes) const {
        const unsigned rank = thread_rank() ^ lanes;
        return shuffle(value, rank < size() ? lane_of(rank) : scotty_cuda::lane_index(),
                       SCOTTY_HERE);
    }
    SCOTTY_CALL int any(int predicate) const { return packed(predicate, SCOTTY_HERE) != 0; }
    SCOTTY_CALL int all(int predicate) const { return packed(predicate == 0, SCOTTY_HERE) == 0; }
    SCOTTY_CALL unsigned ballot(int predicate) const { return packed(predicate, SCOTTY_HERE); }
    template <class T>
    SCOTTY_CALL unsigned match_any(T value) const {
        return pack(static_cast<unsigned>(scotty_cuda::warp(scotty_cuda::WarpOperation::match_any,
                                                            mask_, scotty_cuda::bits_of(value), 0,
                                                            32, nullptr, SCOTTY_HERE)));
    }

 protected:
    unsigned lane_of(unsigned rank) const {
        unsigned bits = mask_;
        for (; rank > 0 && bits != 0; --rank) bits &= bits - 1;
        return bits == 0 ? scotty_cuda::lane_index() : static_cast<unsigned>(__builtin_ctz(bits));
    }
    template <class T>
    T shuffle(T value, unsigned lane, const void* place) const {
        return scotty_cuda::value_of<T>(scotty_cuda::warp(scotty_cuda::WarpOperation::shuffle,
                                                          mask_, scotty_cuda::bits_of(value), lane,
                                                          32, nullptr, place));
    }
    unsigned packed(int predicate, const void* place) const {
        return pack(static_cast<unsigned>(scotty_cuda::warp(
            scotty_cuda::WarpOperation::ballot, mask_, predicate != 0, 0, 32, nullptr, place)));
    }
    /// Lanes as ranks.
    unsigned pack(unsigned lanes) const {
        unsigned out = 0;
        unsigned rank = 0;
        for (unsigned bits = mask_; bits != 0; bits &= bits - 1, ++rank) {
            out |= (lanes >> __builtin_ctz(bits) & 1u) << rank;
        }
        return out;
    }

 private:
    unsigned mask_;
    unsigned meta_rank_;
    unsigned meta_size_;
};

using coalesced_group = lanes_group;
SCOTTY_CALL coalesced_group coalesced_threads() {
    return coalesced_group(static_cast<unsigned>(
        scotty_cuda::warp(scotty_cuda::WarpOperation::active, 0, 0, 0, 32, nullptr, SCOTTY_HERE)));
}

template <unsigned Size, class Parent = void>
class thread_block_tile : public lanes_group {
 public:
    static_assert(Size >= 1 && Size <= 32 && (Size & (Size - 1)) == 0, "1, 2, 4, ... or 32 lanes");
    explicit thread_block_tile(unsigned rank, unsigned threads)
        : lanes_group((Size == 32 ? ~0u : (1u << Size % 32) - 1u) << (rank % 32 & ~(Size - 1)),
                      rank / Size, (threads + Size - 1) / Size) {}
    static constexpr unsigned size() { return Size; }
    static constexpr unsigned num_threads() { return Size; }
};
template <unsigned Size>
thread_block_tile<Size> tiled_partition(const thread_block&) {
    return thread_block_tile<Size>(thread_block::thread_rank(), thread_block::size());
}
template <unsigned Size, unsigned Outer>
thread_block_tile<Size> tiled_partition(const thread_block_tile<Outer>&) {
    return thread_block_tile<Size>(thread_block::thread_rank(), thread_block::size());
}
template <class Group>
void sync(const Group& group) {
    group.sync();
}

template <class T>
struct plus {
    T operator()(T a, T b) const { return a + b; }
};
template <class T>
struct less {
    T operator()(T a, T b) const { return b < a ? b : a; }
};
template <class T>
struct greater {
    T operator()(T a, T b) const { return a < b ? b : a; }
};
template <class Group, class T, class Operation>
T reduce(const Group& group, T value, Operation operation) {
    T total = group.shfl(value, 0);
    for (unsigned rank = 1; rank < group.num_threads(); ++rank) {
        total = operation(total, group.shfl(value, rank));
    }
    return total;
}

}  // namespace cooperative_groups
// NOLINTEND
