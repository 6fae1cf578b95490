/// Faults made by a machine: hands over to verify/mutants/made/made.py, which builds and runs them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace scotty::verify {

/// Its options; empty or 0: its own default.
struct MadeSweep {
    std::string files;  ///< pattern of the paths whose faults are run, as "gpu/*"
    std::size_t sample = 0;
    std::uint64_t seed = 0;
    std::string shard, json;
    std::size_t threads = 0;
};

/// Replaces this process. Throws reference::Error where the sources are not above the program (an
/// installed copy has none), or there is no Python.
[[noreturn]] void become_made_sweep(const MadeSweep& sweep);

}  // namespace scotty::verify
