#include "verify/golden/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "reference/base/error.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

using reference::Error;

namespace {

constexpr const char* kTitle =
    "# stage ledger, version 1: stage, output buffer, XXH64 of its "
    "canonical form";

}  // namespace

Ledger ledger_of(const Capture& capture) {
    const CaptureHeader& header = capture.header();
    Ledger ledger;
    ledger.header = {{"scene", fmt::format("{:016x}", header.scene_fingerprint)},
                     {"bvh", fmt::format("{:016x}", header.bvh_fingerprint)},
                     {"parameters", to_json(header.parameters).dump()}};
    for (const StageRecord& stage : capture.stages()) {
        for (const BufferRecord& buffer : stage.outputs) {
            ledger.lines.push_back({stage.name, buffer.name, buffer.canonical_hash});
        }
    }
    return ledger;
}

std::string to_text(const Ledger& ledger) {
    std::string text = fmt::format("{}\n", kTitle);
    for (const auto& [name, value] : ledger.header) text += fmt::format("# {} {}\n", name, value);
    for (const LedgerLine& line : ledger.lines) {
        text += fmt::format("{} {} {}\n", line.stage, line.buffer, line.hash);
    }
    return text;
}

Ledger read_ledger(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    if (!in || !std::getline(in, line) || line != kTitle) {
        throw Error::bad_input(file.string(), in.is_open() ? fmt::format("line 1: expected '{}'; "
                                                                         "propose it again",
                                                                         kTitle)
                                                           : "cannot be read");
    }
    Ledger ledger;
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        std::istringstream words(line);
        std::string first, second, third, more;
        words >> first >> second;
        if (first == "#") {
            std::getline(words >> std::ws, third);
            ledger.header.emplace_back(second, third);
            continue;
        }
        if (!(words >> third) || third.size() != 16 || words >> more) {
            throw Error::bad_input(file.string(),
                                   fmt::format("line {}: expected a stage, a buffer and 16 "
                                               "hexadecimal digits, found '{:.60}'",
                                               number, line));
        }
        ledger.lines.push_back({first, second, third});
    }
    return ledger;
}

namespace {

bool has_stage(const Ledger& ledger, const std::string& stage) {
    return std::any_of(ledger.lines.begin(), ledger.lines.end(),
                       [&](const LedgerLine& line) { return line.stage == stage; });
}

/// Two lines at the same place that are not the same.
void describe(const Ledger& golden, const Ledger& found, const LedgerLine* expected,
              const LedgerLine* actual, LedgerComparison& result) {
    if (expected != nullptr && actual != nullptr && expected->stage == actual->stage &&
        expected->buffer == actual->buffer) {
        result.stage = expected->stage;
        result.buffer = expected->buffer;
        result.sentence = fmt::format("{}: buffer '{}' hashes to {}, expected {}", result.stage,
                                      result.buffer, actual->hash, expected->hash);
        return;
    }
    const bool is_missing =
        expected != nullptr && (actual == nullptr || !has_stage(found, expected->stage));
    if (is_missing) {
        result.stage = expected->stage;
        result.sentence =
            fmt::format("{}: the golden run has this stage, this one has not", result.stage);
        return;
    }
    result.stage = actual->stage;
    if (has_stage(golden, actual->stage) && expected != nullptr) {
        result.buffer = actual->buffer;
        result.sentence =
            fmt::format("{}: has the buffer '{}' where '{}' of {} was expected", result.stage,
                        actual->buffer, expected->buffer, expected->stage);
        return;
    }
    result.sentence = fmt::format("{}: the golden run has no such stage", result.stage);
}

}  // namespace

LedgerComparison compare_ledgers(const Ledger& golden, const Ledger& found) {
    LedgerComparison result;
    for (std::size_t i = 0; i < std::max(golden.header.size(), found.header.size()); ++i) {
        const std::pair<std::string, std::string> none{"nothing", ""};
        const auto& expected = i < golden.header.size() ? golden.header[i] : none;
        const auto& actual = i < found.header.size() ? found.header[i] : none;
        if (expected == actual) continue;
        result.differing = 1;
        result.sentence = fmt::format("the run is of another {}: '{}', expected '{}'",
                                      expected.first, actual.second, expected.second);
        return result;
    }
    const std::size_t most = std::max(golden.lines.size(), found.lines.size());
    result.compared = most;
    for (std::size_t i = 0; i < most; ++i) {
        const LedgerLine* expected = i < golden.lines.size() ? &golden.lines[i] : nullptr;
        const LedgerLine* actual = i < found.lines.size() ? &found.lines[i] : nullptr;
        if (expected != nullptr && actual != nullptr && *expected == *actual) continue;
        if (result.differing++ == 0) describe(golden, found, expected, actual, result);
    }
    return result;
}

}  // namespace scotty::verify
