#include "verify/backends/machine.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <tbb/task_arena.h>
#include <tbb/version.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <utility>

#include "reference/truth/tracers.h"
#include "verify/backends/cuda/cuda_backend.h"

namespace scotty::verify {

namespace {

/// Cores by socket and number; 0 where /proc/cpuinfo does not tell.
std::uint32_t count_cores() {
    std::ifstream in("/proc/cpuinfo");
    std::set<std::pair<std::string, std::string>> cores;
    std::string line;
    std::string socket;
    while (std::getline(in, line)) {
        if (line.rfind("physical id", 0) == 0) socket = line;
        if (line.rfind("core id", 0) == 0) cores.emplace(socket, line);
    }
    return static_cast<std::uint32_t>(cores.size());
}

std::string operating_system() {
    std::string name = "unknown system";
    std::ifstream in("/etc/os-release");
    const std::string key = "PRETTY_NAME=";
    for (std::string line; std::getline(in, line);) {
        if (line.rfind(key, 0) != 0) continue;
        name = line.substr(key.size());
        std::erase(name, '"');
    }
    utsname kernel{};
    if (uname(&kernel) != 0) return name;
    return fmt::format("{}, {} {} {}", name, kernel.sysname, kernel.release, kernel.machine);
}

std::string compiler() {
#if defined(__clang__)
    return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(__GNUC__)
    return fmt::format("g++ {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#else
    return "unknown compiler";
#endif
}

/// Of this file, which is compiled with the flags of the kernels.
std::string vectors() {
#if defined(__AVX512F__)
    return "AVX-512";
#elif defined(__AVX2__)
    return "AVX2";
#elif defined(__AVX__)
    return "AVX";
#else
    return "the architecture's least";
#endif
}

double load_of_last_minute() {
    double load = -1.0;
    std::ifstream("/proc/loadavg") >> load;
    return load;
}

nlohmann::json to_json(const std::optional<CudaDescription>& cuda) {
    if (!cuda) return nullptr;
    return {{"device", cuda->device},
            {"compute_capability", cuda->compute_capability},
            {"multiprocessors", cuda->multiprocessors},
            {"memory_bytes", cuda->memory_bytes},
            {"driver", cuda->driver},
            {"runtime", cuda->runtime}};
}

}  // namespace

std::string proc_value(const char* file, const std::string& key) {
    std::ifstream in(file);
    std::string line;
    while (std::getline(in, line)) {
        if (line.rfind(key, 0) != 0) continue;
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos) continue;
        const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
        return begin == std::string::npos ? "" : line.substr(begin);
    }
    return "";
}

std::string readable_bytes(std::uint64_t bytes) {
    constexpr double kMebi = 1024.0 * 1024.0;
    const double mebibytes = static_cast<double>(bytes) / kMebi;
    return mebibytes < 1024.0 ? fmt::format("{:.1f} MiB", mebibytes)
                              : fmt::format("{:.1f} GiB", mebibytes / 1024.0);
}

MachineDescription machine_description() {
    MachineDescription machine;
    machine.cpu = proc_value("/proc/cpuinfo", "model name");
    if (machine.cpu.empty()) machine.cpu = "unknown CPU";
    machine.hardware_threads = std::thread::hardware_concurrency();
    machine.cores = count_cores();
    if (machine.cores == 0) machine.cores = machine.hardware_threads;
    machine.usable_threads =
        static_cast<std::uint32_t>(std::max(0, tbb::this_task_arena::max_concurrency()));
    machine.memory_bytes =
        1024 * std::strtoull(proc_value("/proc/meminfo", "MemTotal").c_str(), nullptr, 10);
    machine.os = operating_system();
    machine.build = "scotty " SCOTTY_VERSION " " SCOTTY_BUILD;
    std::replace(machine.build.begin(), machine.build.end(), ',', ' ');
    machine.compiler = compiler();
    machine.vectors = vectors();
    machine.embree = reference::EmbreeTracer::version();
    machine.tbb = TBB_runtime_version();
    machine.cuda = find_cuda();
    machine.load = load_of_last_minute();
    return machine;
}

std::string one_line(const MachineDescription& machine) {
    std::string out =
        fmt::format("{}, {} cores, {} threads, {}; {}; {}, {}, {}; Embree {}", machine.cpu,
                    machine.cores, machine.hardware_threads, readable_bytes(machine.memory_bytes),
                    machine.os, machine.build, machine.compiler, machine.vectors, machine.embree);
    if (machine.cuda) {
        out +=
            fmt::format("; {} ({}), {} multiprocessors, {}, CUDA driver {}, runtime {}",
                        machine.cuda->device, machine.cuda->compute_capability,
                        machine.cuda->multiprocessors, readable_bytes(machine.cuda->memory_bytes),
                        machine.cuda->driver, machine.cuda->runtime);
    }
    if (machine.load >= 0.0) out += fmt::format("; load {:.2f}", machine.load);
    return out;
}

nlohmann::json to_json(const MachineDescription& machine) {
    return {{"cpu", machine.cpu},
            {"cores", machine.cores},
            {"hardware_threads", machine.hardware_threads},
            {"usable_threads", machine.usable_threads},
            {"memory_bytes", machine.memory_bytes},
            {"os", machine.os},
            {"build", machine.build},
            {"compiler", machine.compiler},
            {"vectors", machine.vectors},
            {"embree", machine.embree},
            {"tbb", machine.tbb},
            {"cuda", to_json(machine.cuda)},
            {"load", machine.load}};
}

}  // namespace scotty::verify
