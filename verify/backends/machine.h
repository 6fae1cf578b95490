/// The machine and the build that a figure was measured on: recorded beside every one.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace scotty::verify {

/// The CUDA device that back end `cuda` runs on; versions as people write them: "13.0".
struct CudaDescription {
    std::string device;
    std::string compute_capability;
    int multiprocessors = 0;
    std::uint64_t memory_bytes = 0;
    std::string driver, runtime;  ///< the newest CUDA that the driver serves; what is linked
};

struct MachineDescription {
    std::string cpu;  ///< model, as the processor calls itself
    std::uint32_t cores = 0, hardware_threads = 0;
    std::uint32_t usable_threads = 0;  ///< that TBB would use: of this process's affinity
    std::uint64_t memory_bytes = 0;
    std::string os;                 ///< "Debian GNU/Linux 12 (bookworm), Linux 6.1.0 x86_64"
    std::string build;              ///< version of scotty, build type, flags that change speed
    std::string compiler, vectors;  ///< "g++ 12.2.0"; widest vectors compiled for: "AVX-512"
    std::string embree, tbb;
    std::optional<CudaDescription> cuda;  ///< none without a device; only scotty-cuda sees it
    /// Processes that were running or waiting to, over the last minute, as this was asked for:
    /// what else the machine was doing. Below 0: not known.
    double load = -1.0;
};

/// Looks now; what cannot be found out is "unknown" or 0.
MachineDescription machine_description();

/// One line, no end of line.
std::string one_line(const MachineDescription& machine);
/// "cuda" is null where there is none.
nlohmann::json to_json(const MachineDescription& machine);

/// The value behind the first line that begins with `key`, as /proc files have them; empty where
/// there is none.
std::string proc_value(const char* file, const std::string& key);

/// Bytes as "15.6 GiB" or "3.2 MiB".
std::string readable_bytes(std::uint64_t bytes);

}  // namespace scotty::verify
