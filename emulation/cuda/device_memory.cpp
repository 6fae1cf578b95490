#include "emulation/cuda/device_memory.h"

#include <algorithm>
#include <cstring>

namespace scotty::emulation::cuda {

namespace {

/// What unwritten memory holds; allocations larger than this are not filled with it.
constexpr int kPoison = 0xcd;
constexpr std::size_t kMostPoison = std::size_t{256} << 20;

}  // namespace

DeviceMemory::DeviceMemory()
    : memory_(kBytes, "the device's memory"),
      cells_(kBytes / 4 * sizeof(Cell), "what is known of each word"),
      unwritten_(kBytes / 8, "which bytes are written"),
      begin_(memory_.data()) {}

void* DeviceMemory::allocate(std::size_t bytes, RegionKind kind, std::uint32_t place,
                             bool written) {
    const std::size_t room = (bytes + 255) / 256 * 256 + kGap;
    if (bytes > kBytes || used_ + room > kBytes) return nullptr;
    const std::size_t offset = used_;
    used_ += room;
    in_use_ += bytes;
    auto region = std::make_unique<Region>();
    region->begin = begin_ + offset;
    region->bytes = bytes;
    region->kind = kind;
    region->place = place;
    region->cells = reinterpret_cast<Cell*>(cells_.data()) + offset / 4;
    region->unwritten = reinterpret_cast<std::uint8_t*>(unwritten_.data()) + offset / 8;
    if (!written) {
        if (bytes <= kMostPoison) std::memset(region->begin, kPoison, bytes);
        std::memset(region->unwritten, 0xff, (bytes + 7) / 8);
    }
    std::byte* const begin = region->begin;
    regions_[begin] = std::move(region);
    return begin;
}

void DeviceMemory::add_variable(void* begin, std::size_t bytes, const char* name, RegionKind kind) {
    auto region = std::make_unique<Region>();
    region->begin = static_cast<std::byte*>(begin);
    region->bytes = bytes;
    region->kind = kind;
    region->name = name;
    variable_cells_.push_back(std::make_unique<std::vector<Cell>>((bytes + 3) / 4 + 1));
    region->cells = variable_cells_.back()->data();
    const std::byte* const key = region->begin;
    regions_[key] = std::move(region);
}

Region* DeviceMemory::nearest(const void* address) {
    const auto after = regions_.upper_bound(static_cast<const std::byte*>(address));
    return after == regions_.begin() ? nullptr : std::prev(after)->second.get();
}

Region* DeviceMemory::next(const void* address) {
    const auto after = regions_.upper_bound(static_cast<const std::byte*>(address));
    return after == regions_.end() ? nullptr : after->second.get();
}

Region* DeviceMemory::find(const void* address) {
    const auto* const at = static_cast<const std::byte*>(address);
    if (last_ != nullptr && last_->holds(at)) return last_;
    Region* const below = nearest(address);
    if (below == nullptr || !below->holds(at)) return nullptr;
    return last_ = below;
}

void DeviceMemory::release(Region& region, std::uint32_t place) {
    region.freed = true;
    region.freed_place = place;
    in_use_ -= region.bytes;
}

}  // namespace scotty::emulation::cuda
