/// The diff as text and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "verify/diff/diff.h"

namespace scotty::verify {

using nlohmann::ordered_json;
using reference::kNotApplicable;

namespace {

constexpr std::array kVerdicts{Verdict::identical,        Verdict::reordered,
                               Verdict::within_tolerance, Verdict::within_bounds,
                               Verdict::not_comparable,   Verdict::differs};

struct KindCounts {
    std::map<Verdict, std::uint64_t> by_verdict;
    std::uint64_t missing = 0;
    std::uint64_t stages = 0;
};

std::map<reference::StageKind, KindCounts> counts_by_kind(const DiffReport& report) {
    std::map<reference::StageKind, KindCounts> counts;
    for (const StageResult& stage : report.stages) {
        KindCounts& kind = counts[stage.kind];
        ++kind.stages;
        kind.missing += stage.missing ? 1 : 0;
        ++kind.by_verdict[stage.verdict];
    }
    return counts;
}

std::string place_text(const NonFinite& found) {
    const std::string field = found.field.empty() ? "" : "." + found.field;
    return fmt::format("launch {} {} of {}: {}[{}]{} = {}", found.launch, found.stage,
                       found.in_b ? "B" : "A", found.buffer, found.first_row, field, found.value);
}

ordered_json number(std::uint32_t value) {
    return value == kNotApplicable ? ordered_json(nullptr) : ordered_json(value);
}

ordered_json to_json(const Divergence& d) {
    ordered_json out;
    out["launch"] = number(d.launch);
    out["stage"] = d.stage;
    out["level"] = number(d.level);
    out["node"] = number(d.node);
    out["block"] = number(d.block);
    out["thread"] = number(d.thread);
    out["ray"] = number(d.ray);
    if (d.own_node) out["own_node"] = *d.own_node;
    if (d.own_ray) out["own_ray"] = *d.own_ray;
    out["buffer"] = d.buffer;
    out["field"] = d.field;
    out["input"] = d.input;
    out["a"] = d.a;
    out["b"] = d.b;
    out["ulps"] = d.ulps ? ordered_json(*d.ulps) : ordered_json(nullptr);
    out["what"] = d.sentence;
    out["pixel_x"] = number(d.pixel_x);
    out["pixel_y"] = number(d.pixel_y);
    out["sample"] = number(d.sample);
    out["replay"] = d.replay;
    if (!d.written_by.empty()) out["written_by"] = d.written_by;
    return out;
}

ordered_json to_json(const NonFinite& found) {
    ordered_json out;
    out["side"] = found.in_b ? "b" : "a";
    out["launch"] = found.launch;
    out["stage"] = found.stage;
    out["buffer"] = found.buffer;
    out["values"] = found.values;
    out["first_row"] = found.first_row;
    out["field"] = found.field;
    out["value"] = found.value;
    return out;
}

/// Empty columns are left out.
std::string table(const DiffReport& report) {
    const auto counts = counts_by_kind(report);
    std::vector<Verdict> columns;
    std::uint64_t missing = 0;
    for (const Verdict verdict : kVerdicts) {
        for (const auto& [kind, count] : counts) {
            if (!count.by_verdict.contains(verdict)) continue;
            columns.push_back(verdict);
            break;
        }
    }
    for (const auto& [kind, count] : counts) missing += count.missing;
    std::string text = fmt::format("{:<22}{:>8}", "stages by kind", "stages");
    for (const Verdict verdict : columns) text += fmt::format("  {:>13}", to_string(verdict));
    if (missing != 0) text += fmt::format("  {:>8}", "missing");
    text += '\n';
    for (const auto& [kind, count] : counts) {
        text += fmt::format("{:<22}{:>8}", reference::to_string(kind), count.stages);
        for (const Verdict verdict : columns) {
            const auto found = count.by_verdict.find(verdict);
            const std::uint64_t shown = found == count.by_verdict.end() ? 0 : found->second;
            text += fmt::format("  {:>{}}", shown,
                                std::max<std::size_t>(13, std::string(to_string(verdict)).size()));
        }
        if (missing != 0) text += fmt::format("  {:>8}", count.missing);
        text += '\n';
    }
    return text;
}

}  // namespace

bool DiffReport::passed() const {
    return tree_violations.empty() &&
           std::none_of(stages.begin(), stages.end(),
                        [](const StageResult& stage) { return stage.failed(); });
}

const Divergence* DiffReport::first() const {
    for (const StageResult& stage : stages) {
        if (stage.first) return &*stage.first;
    }
    return nullptr;
}

std::uint64_t DiffReport::non_finite_values() const {
    std::uint64_t values = 0;
    for (const StageResult& stage : stages) {
        for (const NonFinite& found : stage.non_finite) values += found.values;
    }
    return values;
}

const NonFinite* DiffReport::first_non_finite() const {
    for (const StageResult& stage : stages) {
        if (!stage.non_finite.empty()) return &stage.non_finite.front();
    }
    return nullptr;
}

std::string to_text(const Divergence& d) {
    std::string text = fmt::format("launch {} {}", d.launch, d.stage);
    if (d.level != kNotApplicable) text += fmt::format(", level {}", d.level);
    if (d.own_node) {
        text += fmt::format(", node {} ({} in the capture)", *d.own_node, d.node);
    } else if (d.node != kNotApplicable) {
        text += fmt::format(", node {}", d.node);
    }
    if (d.block != kNotApplicable) text += fmt::format(", block {}", d.block);
    if (d.thread != kNotApplicable) text += fmt::format(", thread {}", d.thread);
    if (d.own_ray) {
        text += fmt::format(", ray {} ({} in the capture)", *d.own_ray, d.ray);
    } else if (d.ray != kNotApplicable) {
        text += fmt::format(", ray {}", d.ray);
    }
    text += ": " + d.sentence + "\n";
    if (!d.a.empty() || !d.b.empty()) {
        std::string field = d.buffer;
        if (!d.field.empty()) field += (field.empty() ? "" : ".") + d.field;
        text += fmt::format("  {}: A {}, B {}", field, d.a, d.b);
        if (d.ulps) text += fmt::format(", {} ulps apart", *d.ulps);
        text += '\n';
    } else if (!d.buffer.empty()) {
        text += fmt::format("  {}\n", d.buffer);
    }
    if (d.pixel_x != kNotApplicable) {
        text += d.sample != kNotApplicable
                    ? fmt::format("  the ray belongs to pixel ({}, {}), sample {}\n", d.pixel_x,
                                  d.pixel_y, d.sample)
                    : fmt::format("  pixel ({}, {})\n", d.pixel_x, d.pixel_y);
    }
    if (!d.written_by.empty()) text += fmt::format("  B's was written by {}\n", d.written_by);
    if (!d.replay.empty()) text += fmt::format("  run it again: {}\n", d.replay);
    return text;
}

std::string to_text(const DiffReport& report) {
    std::string text =
        fmt::format("A: {} ({})\nB: {} ({}){}\n", report.a, report.a_backend, report.b,
                    report.b_backend, report.isolated ? ", each stage alone, on A's inputs" : "");
    std::uint64_t failed = 0;
    for (const StageResult& stage : report.stages) failed += stage.failed() ? 1 : 0;
    for (const std::string& violation : report.tree_violations) {
        text += fmt::format("the capture's tree is not sound: {}\n", violation);
    }
    if (report.passed()) {
        text += fmt::format("passed: {} stages compared\n", report.stages.size());
    } else {
        text += fmt::format("FAILED: {} of {} stages\n", failed, report.stages.size());
    }
    if (const NonFinite* found = report.first_non_finite()) {
        text += fmt::format("\n{} values are not finite; the first: {}\n",
                            report.non_finite_values(), place_text(*found));
    }
    if (const Divergence* first = report.first()) {
        text += "\nfirst divergence: " + to_text(*first);
    }
    if (report.excused != 0) {
        text += fmt::format(
            "\n{} differences are within the rounding of float tests (a ray that grazes a box or "
            "an "
            "edge, two hits in one place)\n",
            report.excused);
    }
    if (!report.not_given.empty()) {
        text += fmt::format("\nnot judged, because the capture does not hold it: {}\n",
                            fmt::join(report.not_given, "; "));
    }
    if (report.not_compared != 0) {
        text += fmt::format(
            "\n{} stages are in one capture only, by request, and were not "
            "compared\n",
            report.not_compared);
    }
    return text + "\n" + table(report);
}

ordered_json to_json(const StageResult& stage) {
    ordered_json out;
    out["name"] = stage.name;
    out["kind"] = reference::to_string(stage.kind);
    out["launch"] = stage.launch;
    out["verdict"] = to_string(stage.verdict);
    out["missing"] = stage.missing;
    out["buffers"] = ordered_json::array();
    for (const BufferResult& buffer : stage.buffers) {
        ordered_json entry;
        entry["name"] = buffer.name;
        entry["input"] = buffer.input;
        entry["verdict"] = to_string(buffer.verdict);
        entry["different"] = buffer.different;
        out["buffers"].push_back(std::move(entry));
    }
    out["non_finite"] = ordered_json::array();
    for (const NonFinite& found : stage.non_finite) out["non_finite"].push_back(to_json(found));
    out["first_divergence"] = stage.first ? to_json(*stage.first) : ordered_json(nullptr);
    return out;
}

ordered_json to_json(const DiffReport& report) {
    ordered_json out;
    out["passed"] = report.passed();
    out["a"] = {{"name", report.a}, {"backend", report.a_backend}};
    out["b"] = {{"name", report.b}, {"backend", report.b_backend}};
    out["isolated"] = report.isolated;
    out["non_finite_values"] = report.non_finite_values();
    const NonFinite* non_finite = report.first_non_finite();
    out["first_non_finite"] = non_finite != nullptr ? to_json(*non_finite) : ordered_json(nullptr);
    const Divergence* first = report.first();
    out["first_divergence"] = first != nullptr ? to_json(*first) : ordered_json(nullptr);
    out["not_compared"] = report.not_compared;
    if (!report.not_given.empty()) out["not_given"] = report.not_given;
    if (!report.tree_violations.empty()) out["tree_violations"] = report.tree_violations;
    if (report.excused != 0) out["excused"] = report.excused;
    ordered_json kinds = ordered_json::object();
    for (const auto& [kind, count] : counts_by_kind(report)) {
        ordered_json entry;
        entry["stages"] = count.stages;
        for (const Verdict verdict : kVerdicts) {
            const auto found = count.by_verdict.find(verdict);
            entry[to_string(verdict)] = found == count.by_verdict.end() ? 0 : found->second;
        }
        entry["missing"] = count.missing;
        kinds[reference::to_string(kind)] = std::move(entry);
    }
    out["kinds"] = std::move(kinds);
    out["stages"] = ordered_json::array();
    for (const StageResult& stage : report.stages) out["stages"].push_back(to_json(stage));
    return out;
}

}  // namespace scotty::verify
