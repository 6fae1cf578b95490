#include "emulation/cuda/findings.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "emulation/check/source_line.h"

namespace scotty::emulation::cuda {

namespace {

constexpr std::size_t kMostFindings = 1000;

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            char code[8];
            std::snprintf(code, sizeof code, "\\u%04x", c);
            out += code;
        } else {
            out += c;
        }
    }
    return out + "\"";
}

std::string dim(const scotty_cuda::Dim& dim) {
    return "(" + std::to_string(dim.x) + "," + std::to_string(dim.y) + "," + std::to_string(dim.z) +
           ")";
}

std::string json_dim(const scotty_cuda::Dim& dim) {
    return "[" + std::to_string(dim.x) + "," + std::to_string(dim.y) + "," + std::to_string(dim.z) +
           "]";
}

std::string line_of(std::uint32_t place) {
    return place == 0 ? "" : simt::source_line(place, simt::LineOf::user);
}

std::string actor_text(const Actor& actor) {
    std::string text;
    if (actor.in_kernel) {
        text = "thread " + dim(actor.thread) + " of block " + dim(actor.block);
        if (!actor.does.empty()) text += " " + actor.does;
    } else {
        text = actor.does.empty() ? "the host" : "the host " + actor.does;
    }
    const std::string line = line_of(actor.place);
    return line.empty() ? text : text + " at " + line;
}

/// The user's lines that call, innermost first, without the kernel's launcher.
std::vector<std::string> callers(const CallTree& calls, const Actor& actor) {
    std::vector<std::string> lines;
    if (!actor.known || !actor.in_kernel) return lines;
    for (const std::uint32_t place : calls.places(actor.stack)) {
        const std::string line = line_of(place);
        if (line.find("scotty_cuda/") != std::string::npos || line.find(':') == std::string::npos) {
            continue;
        }
        if (lines.empty() ? line != line_of(actor.place) : line != lines.back()) {
            lines.push_back(line);
        }
    }
    return lines;
}

std::string actor_json(const CallTree& calls, const Actor& actor) {
    std::string text =
        "{\"does\":" + quoted(actor.does) + ",\"line\":" + quoted(line_of(actor.place));
    if (actor.in_kernel) {
        text += ",\"block\":" + json_dim(actor.block) + ",\"thread\":" + json_dim(actor.thread);
        text += ",\"called_from\":[";
        bool first = true;
        for (const std::string& line : callers(calls, actor)) {
            text += (first ? "" : ",") + quoted(line);
            first = false;
        }
        text += "]";
    }
    return text + "}";
}

}  // namespace

const char* to_string(FindingKind kind) {
    switch (kind) {
        case FindingKind::race:
            return "data race";
        case FindingKind::same_value_race:
            return "same-value race";
        case FindingKind::divergence:
            return "divergence";
        case FindingKind::bounds:
            return "out of bounds";
        case FindingKind::freed:
            return "freed memory";
        case FindingKind::constant_write:
            return "constant written";
        case FindingKind::host_memory:
            return "host memory in a kernel";
        case FindingKind::device_memory:
            return "device memory on the host";
        case FindingKind::misaligned:
            return "misaligned";
        case FindingKind::unwritten:
            return "unwritten memory";
        case FindingKind::endless:
            return "endless wait";
        case FindingKind::assertion:
            return "assertion failed";
        case FindingKind::trap:
            return "kernel failed";
        case FindingKind::launch:
            return "launch failed";
        case FindingKind::call:
            return "wrong call";
        case FindingKind::leak:
            return "leak";
    }
    return "";
}

bool is_warning(FindingKind kind) {
    return kind == FindingKind::same_value_race || kind == FindingKind::leak;
}

std::vector<std::uint32_t> CallTree::places(std::uint32_t node) const {
    std::vector<std::uint32_t> out;
    for (; node != 0; node = nodes_[node].parent) out.push_back(nodes_[node].place);
    return out;
}

void Findings::leave_copies(Actor& actor) const {
    while (calls_.is_copy(actor.stack)) {
        actor.place = calls_.place(actor.stack);
        actor.stack = calls_.parent(actor.stack);
    }
}

std::size_t Findings::add(Finding finding) {
    leave_copies(finding.one);
    leave_copies(finding.other);
    // What races, not where in it: neighbours of one array are one finding.
    std::string subject;
    if (finding.kind != FindingKind::race && finding.kind != FindingKind::same_value_race) {
        subject = finding.what.substr(0, finding.what.find(','));
    }
    const auto [low, high] = std::minmax(finding.one.place, finding.other.place);
    auto key = std::make_tuple(finding.kind, finding.kernel, low, high, subject);
    if (finding.kind == FindingKind::same_value_race) {
        // It may have turned out to be a race before.
        auto as_race = key;
        std::get<0>(as_race) = FindingKind::race;
        const auto known = known_.find(as_race);
        if (known != known_.end()) {
            ++findings_[known->second].times;
            return known->second;
        }
    }
    const auto [at, is_new] = known_.try_emplace(std::move(key), findings_.size());
    if (!is_new) {
        ++findings_[at->second].times;
        return at->second;
    }
    if (findings_.size() >= kMostFindings) {
        at->second = findings_.size() - 1;
        return at->second;
    }
    findings_.push_back(std::move(finding));
    return findings_.size() - 1;
}

void Findings::make_race(std::size_t position) {
    if (position >= findings_.size()) return;  // it has been taken
    Finding& finding = findings_[position];
    if (finding.kind != FindingKind::same_value_race) return;
    finding.kind = FindingKind::race;
    const auto [low, high] = std::minmax(finding.one.place, finding.other.place);
    known_.try_emplace({FindingKind::race, finding.kernel, low, high, ""}, position);
}

bool Findings::passes() const {
    return std::all_of(findings_.begin(), findings_.end(),
                       [](const Finding& finding) { return is_warning(finding.kind); });
}

std::string Findings::take(bool warnings) {
    if (!warnings) {
        std::erase_if(findings_, [](const Finding& finding) { return is_warning(finding.kind); });
    }
    std::string text = to_text();
    findings_.clear();
    known_.clear();
    return text;
}

std::vector<Finding> Findings::sorted() const {
    std::vector<Finding> out = findings_;
    std::vector<std::uint32_t> places;
    for (Finding& finding : out) {
        leave_copies(finding.one);
        leave_copies(finding.other);
        for (const Actor* actor : {&finding.one, &finding.other}) {
            places.push_back(actor->place);
            for (const std::uint32_t place : calls_.places(actor->stack)) places.push_back(place);
        }
        places.push_back(finding.allocated);
    }
    simt::source_lines(places, simt::LineOf::user);  // all at once, which is much quicker
    std::stable_sort(out.begin(), out.end(), [](const Finding& a, const Finding& b) {
        return std::tie(a.kind, a.kernel, a.one.place, a.other.place) <
               std::tie(b.kind, b.kernel, b.one.place, b.other.place);
    });
    return out;
}

std::string Findings::to_text() const {
    std::string text;
    for (const Finding& finding : sorted()) {
        text += std::string(to_string(finding.kind)) + ": " + finding.what;
        if (!finding.kernel.empty()) text += ", in kernel " + finding.kernel;
        if (finding.times > 1) text += " (" + std::to_string(finding.times) + " times)";
        text += "\n";
        for (const Actor* actor : {&finding.other, &finding.one}) {
            if (!actor->known) continue;
            text += "    " + actor_text(*actor) + "\n";
            for (const std::string& line : callers(calls_, *actor)) {
                text += "        called at " + line + "\n";
            }
        }
        if (finding.allocated != 0) text += "    allocated at " + line_of(finding.allocated) + "\n";
    }
    return text;
}

std::string Findings::to_json() const {
    std::string text = "{\"findings\":[";
    bool first = true;
    for (const Finding& finding : sorted()) {
        text += first ? "\n" : ",\n";
        first = false;
        text += "{\"kind\":" + quoted(to_string(finding.kind)) +
                ",\"warning\":" + (is_warning(finding.kind) ? "true" : "false") +
                ",\"kernel\":" + quoted(finding.kernel) + ",\"what\":" + quoted(finding.what) +
                ",\"times\":" + std::to_string(finding.times);
        if (finding.one.known) text += ",\"one\":" + actor_json(calls_, finding.one);
        if (finding.other.known) text += ",\"other\":" + actor_json(calls_, finding.other);
        if (finding.allocated != 0) text += ",\"allocated\":" + quoted(line_of(finding.allocated));
        text += "}";
    }
    return text + "\n]}\n";
}

}  // namespace scotty::emulation::cuda
