#include "emulation/check/checker_memory.h"

#include <mutex>
#include <utility>

namespace scotty::emulation::simt {

namespace {

constexpr std::size_t kWords = CheckerMemory::kDeviceBytes / 4;
/// Half of all block numbers: at least that many are left to the next checker.
constexpr std::uint32_t kManyBlocks = 1u << 31;

struct Kept {
    std::mutex mutex;
    std::unique_ptr<CheckerMemory> memory;
};
Kept& kept() {
    static Kept one;
    return one;
}

}  // namespace

CheckerMemory::CheckerMemory()
    : device_(kDeviceBytes, "the device's memory"),
      plain_(kWords * sizeof(Shadow), "what is known of each word"),
      others_(kWords * sizeof(Shadow), "what is known of each atomic"),
      states_(kWords, "which words are written") {}

std::unique_ptr<CheckerMemory> take_checker_memory() {
    std::unique_ptr<CheckerMemory> memory;
    {
        const std::scoped_lock lock(kept().mutex);
        memory = std::exchange(kept().memory, nullptr);
    }
    return memory != nullptr ? std::move(memory) : std::make_unique<CheckerMemory>();
}

void give_back(std::unique_ptr<CheckerMemory> memory) {
    if (memory->next_block > kManyBlocks) return;
    const std::scoped_lock lock(kept().mutex);
    kept().memory = std::move(memory);
}

}  // namespace scotty::emulation::simt
