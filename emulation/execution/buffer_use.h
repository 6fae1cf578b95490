/// The use of a virtual device's buffer, as far as the checker can hold a kernel to it.
#pragma once

namespace scotty::emulation {

/// each_slot_once: a launch writes each slot at most once.
enum class BufferUse { any, each_slot_once };

}  // namespace scotty::emulation
