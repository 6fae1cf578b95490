#include "emulation/check/source_line.h"

#include <link.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>

namespace scotty::emulation::simt {

namespace {

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    std::string text;
    if (pipe == nullptr) return text;
    std::array<char, 4096> piece{};
    while (const std::size_t got = std::fread(piece.data(), 1, piece.size(), pipe.get())) {
        text.append(piece.data(), got);
    }
    return text;
}

/// Kernels, their host side and the stages' text that they share, and tests; not the code that they
/// build on.
bool is_kernel_text(std::string_view line) {
    const auto has = [&](std::string_view part) {
        return line.find(part) != std::string_view::npos;
    };
    if (has("gpu/") || has("tests/")) return true;
    return has("emulation/kernels/") || has("emulation/host/") || has("reference/stages/");
}

/// Neither the system's headers nor those of the executor of CUDA programs.
bool is_user_text(std::string_view line) {
    return !line.starts_with("/usr/") && line.find("scotty_cuda/") == std::string_view::npos;
}

/// addr2line prints the address and then a line for each inlined call, innermost first.
std::map<std::uint32_t, std::string> parse(const std::string& text, LineOf which) {
    const auto is_wanted = which == LineOf::user ? is_user_text : is_kernel_text;
    std::map<std::uint32_t, std::string> lines;
    std::uint32_t offset = 0;
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string line = text.substr(at, end - at);
        at = end + 1;
        if (line.starts_with("0x")) {
            offset = static_cast<std::uint32_t>(std::stoul(line, nullptr, 16));
            continue;
        }
        if (const std::size_t extra = line.find(" (discriminator"); extra != std::string::npos) {
            line.resize(extra);
        }
        if (line.starts_with("?")) continue;
        line = std::filesystem::path(line).lexically_normal().string();
        std::string& known = lines[offset];
        if (known.empty() || (!is_wanted(known) && is_wanted(line))) known = line;
    }
    return lines;
}

}  // namespace

std::uintptr_t program_begin() {
    std::uintptr_t begin = 0;
    // The first object that the loader names is the program itself.
    ::dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* found) {
            *static_cast<std::uintptr_t*>(found) = info->dlpi_addr;
            return 1;
        },
        &begin);
    return begin;
}

std::vector<std::string> source_lines(const std::vector<std::uint32_t>& offsets, LineOf which) {
    static std::mutex mutex;
    static std::map<std::uint32_t, std::string> known_lines[2];
    const std::scoped_lock lock(mutex);
    std::map<std::uint32_t, std::string>& known = known_lines[static_cast<std::size_t>(which)];
    std::string command;
    for (const std::uint32_t offset : offsets) {
        // A return address is behind the call, so look one byte back.
        if (offset != 0 && !known.contains(offset)) {
            char text[16];
            std::snprintf(text, sizeof text, " 0x%x", offset - 1);
            command += text;
        }
    }
    if (!command.empty()) {
        command.insert(0, "addr2line -a -i -e /proc/" + std::to_string(::getpid()) + "/exe");
        for (auto& [offset, line] : parse(output_of(command.append(" 2>/dev/null")), which)) {
            known[offset + 1] = std::move(line);
        }
    }
    std::vector<std::string> lines;
    for (const std::uint32_t offset : offsets) {
        std::string& line = known[offset];
        if (line.empty()) {
            char text[32];
            std::snprintf(text, sizeof text, "scotty+0x%x", offset);
            line = text;
        }
        lines.push_back(line);
    }
    return lines;
}

std::string source_line(std::uint32_t offset, LineOf which) {
    return source_lines({offset}, which).front();
}

}  // namespace scotty::emulation::simt
