/// Marks the current read as one that other threads may overtake (load_relaxed), and not as the
/// read with which an atomic begins.
#pragma once

namespace scotty::emulation::simt {

inline constinit thread_local bool deliberate_read = false;

struct Deliberate {
    Deliberate() { deliberate_read = true; }
    ~Deliberate() { deliberate_read = false; }
    Deliberate(const Deliberate&) = delete;
    Deliberate& operator=(const Deliberate&) = delete;
};

}  // namespace scotty::emulation::simt
