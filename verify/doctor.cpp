#include "verify/doctor.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <tbb/version.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "reference/error.h"
#include "reference/tracers.h"
#include "scenes/scenes.h"
#include "verify/ask.h"

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

/// The value behind the first line that begins with `key`, as /proc files have them.
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

/// A program on the PATH or in one of `also`; empty where it is not.
std::string find_program(const std::string& name, const std::vector<std::string>& also) {
    std::vector<std::string> folders;
    const char* path = std::getenv("PATH");
    std::string rest = path == nullptr ? "" : path;
    while (!rest.empty()) {
        const std::size_t colon = rest.find(':');
        folders.push_back(rest.substr(0, colon));
        rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
    }
    folders.insert(folders.end(), also.begin(), also.end());
    for (const std::string& folder : folders) {
        std::string candidate = fmt::format("{}/{}", folder, name);
        if (!folder.empty() && access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    return "";
}

Finding find_embree() {
    Finding finding{"Embree", true, true, reference::EmbreeTracer::version()};
    try {
        reference::Scene triangle;
        triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        triangle.triangles = {{0, 1, 2}};
        const reference::EmbreeTracer tracer(triangle);
    } catch (const reference::Error& error) {
        finding.found = false;
        finding.detail += std::string(", but it does not start: ") + error.what();
    }
    return finding;
}

Finding find_cuda_compiler() {
    const std::string nvcc = find_program("nvcc", {"/usr/local/cuda/bin"});
    if (nvcc.empty()) {
        return {"CUDA compiler", false, false, "no nvcc: gpu/ is left out of the build"};
    }
    return {"CUDA compiler", true, false, nvcc + ", " + ask("'" + nvcc + "' --version")};
}

Finding find_cuda_driver() {
    const std::string version = proc_value("/proc/driver/nvidia/version", "NVRM version");
    if (version.empty()) {
        return {"CUDA driver", false, false, "no NVIDIA driver: everything runs on the CPU"};
    }
    return {"CUDA driver", true, false, version};
}

Finding find_cuda_device() {
    const std::string smi = find_program("nvidia-smi", {});
    const std::string device =
        smi.empty() ? "" : ask("'" + smi + "' --query-gpu=name,memory.total --format=csv,noheader");
    if (!device.empty()) return {"CUDA device", true, false, device};
    std::error_code ignored;
    if (fs::exists("/dev/nvidia0", ignored)) return {"CUDA device", true, false, "/dev/nvidia0"};
    return {"CUDA device", false, false, "none: tests that need one say 'skipped'"};
}

Finding find_scenes() {
    std::string names;
    for (const scenes::BuiltIn& scene : scenes::built_in_scenes()) {
        names += (names.empty() ? "" : ", ") + scene.name;
    }
    std::error_code ignored;
    return {"scenes", true, true,
            fmt::format("built in: {}; files by path, from {}", names,
                        fs::current_path(ignored).string())};
}

}  // namespace

std::vector<Finding> examine_machine() {
    std::vector<Finding> findings;
    const std::string model = proc_value("/proc/cpuinfo", "model name");
    findings.push_back(
        {"CPU", true, true,
         fmt::format("{}, {} hardware threads, {} usable", model.empty() ? "unknown model" : model,
                     std::thread::hardware_concurrency(),
                     tbb::this_task_arena::max_concurrency())});
    const auto gibibytes = [](const std::string& text) {
        return static_cast<double>(std::strtoull(text.c_str(), nullptr, 10)) / (1024.0 * 1024.0);
    };
    findings.push_back({"memory", true, true,
                        fmt::format("{:.1f} GiB, {:.1f} GiB available",
                                    gibibytes(proc_value("/proc/meminfo", "MemTotal")),
                                    gibibytes(proc_value("/proc/meminfo", "MemAvailable")))});
    findings.push_back({"TBB", true, true, TBB_runtime_version()});
    findings.push_back(find_embree());
    findings.push_back({"OpenImageIO", true, true,
                        fmt::format("{}, built against {}",
                                    OIIO::get_string_attribute("version", "version unknown"),
                                    OIIO_VERSION_STRING)});
    findings.push_back(find_cuda_compiler());
    findings.push_back(find_cuda_driver());
    findings.push_back(find_cuda_device());
    findings.push_back(find_scenes());
    return findings;
}

std::string table(const std::vector<Finding>& findings) {
    std::string out;
    for (const Finding& finding : findings) {
        out += fmt::format("{:<14} {:<8} {}\n", finding.name,
                           finding.found ? "ok" : (finding.required ? "MISSING" : "none"),
                           finding.detail);
    }
    return out;
}

nlohmann::json to_json(const std::vector<Finding>& findings) {
    nlohmann::json out = nlohmann::json::array();
    for (const Finding& finding : findings) {
        out.push_back({{"name", finding.name},
                       {"found", finding.found},
                       {"required", finding.required},
                       {"detail", finding.detail}});
    }
    return out;
}

}  // namespace scotty::verify
