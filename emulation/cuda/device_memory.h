/// The simulated device's memory: allocations with gaps between, and variables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "emulation/check/mapped_memory.h"
#include "emulation/cuda/shadow.h"

namespace scotty::emulation::cuda {

class DeviceMemory {
 public:
    static constexpr std::size_t kBytes = std::size_t{16} << 30;
    /// Between two allocations, so that a step beyond one does not land in the next.
    static constexpr std::size_t kGap = 4096;

    /// Reserves address space, not memory.
    DeviceMemory();

    /// Null where there is no room. Memory of the device begins unwritten.
    void* allocate(std::size_t bytes, RegionKind kind, std::uint32_t place, bool written);
    /// Registers a variable of the program.
    void add_variable(void* begin, std::size_t bytes, const char* name, RegionKind kind);

    bool in_arena(const void* address) const {
        return static_cast<std::size_t>(static_cast<const std::byte*>(address) - begin_) < kBytes;
    }
    /// The allocation or variable that holds the address, freed ones included, or null.
    Region* find(const void* address);
    /// The allocation nearest below the address, or null.
    Region* nearest(const void* address);
    /// The one nearest above it, or null.
    Region* next(const void* address);
    const std::map<const std::byte*, std::unique_ptr<Region>>& regions() const { return regions_; }
    std::size_t in_use() const { return in_use_; }
    void release(Region& region, std::uint32_t place);

 private:
    simt::MappedMemory memory_;
    simt::MappedMemory cells_;
    simt::MappedMemory unwritten_;
    std::byte* begin_;
    std::size_t used_ = kGap;
    std::size_t in_use_ = 0;
    std::map<const std::byte*, std::unique_ptr<Region>> regions_;
    std::vector<std::unique_ptr<std::vector<Cell>>> variable_cells_;
    Region* last_ = nullptr;
};

}  // namespace scotty::emulation::cuda
