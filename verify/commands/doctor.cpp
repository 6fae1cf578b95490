#include "verify/commands/doctor.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "verify/backends/machine.h"
#include "verify/base/ask.h"
#include "verify/images/image_library.h"

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

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

Finding find_image_module() {
    try {
        return {"OpenImageIO", true, false, image_module().version()};
    } catch (const reference::Error& error) {
        return {"OpenImageIO", false, false, error.what()};
    }
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
    const MachineDescription machine = machine_description();
    findings.push_back(
        {"CPU", true, true,
         fmt::format("{}, {} cores, {} hardware threads, {} usable", machine.cpu, machine.cores,
                     machine.hardware_threads, machine.usable_threads)});
    const std::string available = proc_value("/proc/meminfo", "MemAvailable");
    findings.push_back(
        {"memory", true, true,
         fmt::format("{}, {} available", readable_bytes(machine.memory_bytes),
                     readable_bytes(1024 * std::strtoull(available.c_str(), nullptr, 10)))});
    findings.push_back({"system", true, true, machine.os});
    findings.push_back(
        {"build", true, true,
         fmt::format("{}, {}, {}", machine.build, machine.compiler, machine.vectors)});
    findings.push_back({"TBB", true, true, machine.tbb});
    findings.push_back(find_embree());
    findings.push_back(find_image_module());
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
