#include "emulation/execution/shared_memory.h"

#include <cstring>

namespace scotty::emulation::simt {

void fill_with_poison(std::byte* memory, std::size_t bytes) {
    std::memset(memory, kPoisonByte, bytes);
}

}  // namespace scotty::emulation::simt
