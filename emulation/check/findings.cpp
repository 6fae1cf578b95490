// The checker's findings as text, and as the error that a launch fails with.
#include <algorithm>
#include <string>
#include <tuple>

#include "emulation/check/memory_checker.h"
#include "emulation/check/source_line.h"
#include "emulation/execution/launch_error.h"

namespace scotty::emulation::simt {

namespace {

const char* verb(Access access) {
    switch (access) {
        case Access::read:
            return "reads it";
        case Access::write:
            return "writes it";
        case Access::atomic:
            return "changes it atomically";
        case Access::relaxed_read:
            return "reads it while others may write";
    }
    return "";
}

std::string who_text(std::uint32_t thread, std::uint32_t block) {
    if (block == kSomeOther) return "a thread of another block";
    if (thread == kSomeOther) return "some thread of block " + std::to_string(block);
    return "thread " + std::to_string(thread) + " of block " + std::to_string(block);
}

/// Races come first, because they explain unwritten memory; the rest is in an order that does not
/// depend on timing.
[[noreturn]] void throw_findings(const std::string& kernel, std::uint32_t threads,
                                 std::vector<MemoryFinding> findings, const std::string& after) {
    std::sort(findings.begin(), findings.end(), [](const auto& a, const auto& b) {
        return std::tie(a.kind, a.block, a.thread, a.place) <
               std::tie(b.kind, b.block, b.thread, b.place);
    });
    std::string what = to_text(findings.front());
    if (findings.size() > 1) {
        what += " (and " + std::to_string(findings.size() - 1) +
                " more, such as: " + to_text(findings[1]) + ")";
    }
    throw LaunchError(kernel, findings.front().block, threads, {}, what + after);
}

}  // namespace

std::string to_text(const MemoryFinding& finding) {
    const std::vector<std::string> lines = source_lines({finding.place, finding.other_place});
    std::string one =
        who_text(finding.thread, finding.block) + " " + verb(finding.access) + " at " + lines[0];
    switch (finding.kind) {
        case MemoryFinding::Kind::race:
            return "data race on " + finding.memory + ": " +
                   who_text(finding.other_thread, finding.other_block) + " " +
                   verb(finding.other_access) + " at " + lines[1] + ", " + one +
                   (finding.block == finding.other_block ? ", and no barrier is between" : "");
        case MemoryFinding::Kind::foreign:
            return who_text(finding.thread, finding.block) + " touches a register of thread " +
                   std::to_string(finding.other_thread) + " at " + lines[0] +
                   "; what threads hand to each other is Shared";
        case MemoryFinding::Kind::no_register:
            return "memory touched in a phase on registers, " + finding.memory + ": " + one;
        case MemoryFinding::Kind::twice:
            return "slot written twice, " + finding.memory + ": " +
                   who_text(finding.other_thread, finding.other_block) + " " +
                   verb(finding.other_access) + " at " + lines[1] + ", " + one;
        case MemoryFinding::Kind::unwritten:
            return "nobody has written " + finding.memory + ": " + one;
        case MemoryFinding::Kind::outside:
            return "out of bounds, " + finding.memory + ": " + one;
        case MemoryFinding::Kind::freed:
            return "freed memory, " + finding.memory + ": " + one;
    }
    return one;
}

void throw_findings_of(MemoryChecker& checker, const std::string& kernel, std::uint32_t threads,
                       const std::function<void()>& run_blocks) {
    try {
        run_blocks();
    } catch (const LaunchError& error) {
        const std::vector<MemoryFinding> findings = checker.take_findings();
        if (findings.empty()) throw;
        throw_findings(kernel, threads, findings, std::string("; then ") + error.what());
    }
    const std::vector<MemoryFinding> findings = checker.take_findings();
    if (!findings.empty()) throw_findings(kernel, threads, findings, "");
}

}  // namespace scotty::emulation::simt
