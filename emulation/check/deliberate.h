/// Marks the read that is under way as one that others may overtake (load_relaxed), and not as the
/// look that an atomic takes before it acts.
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
