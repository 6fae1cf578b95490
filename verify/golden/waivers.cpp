#include "verify/golden/waivers.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/capture_format.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

using reference::Error;

namespace {

constexpr const char* kWaiverFormat = "cuda-scotty-waivers";
constexpr int kVersion = 1;
constexpr const char* kAnyDevice = "*";

/// Years of four digits, months and days of two, and a day that its month has.
bool is_date(const std::string& text) {
    std::tm parsed{};
    const char* end = strptime(text.c_str(), "%Y-%m-%d", &parsed);
    if (text.size() != 10 || end == nullptr || *end != '\0') return false;
    std::tm normal = parsed;
    normal.tm_hour = 12;
    const std::time_t time = timegm(&normal);
    return time != -1 && normal.tm_mday == parsed.tm_mday && normal.tm_mon == parsed.tm_mon;
}

std::string optional_text(const std::string& where, const nlohmann::json& object,
                          const char* name) {
    return object.contains(name) ? text_member(where, object, name) : "";
}

Waiver parse_waiver(const std::string& where, const nlohmann::json& object) {
    Waiver waiver;
    waiver.golden = text_member(where, object, "case");
    waiver.gate = optional_text(where, object, "gate");
    waiver.stage = optional_text(where, object, "stage");
    waiver.device = text_member(where, object, "device");
    waiver.reason = text_member(where, object, "reason");
    waiver.expires = text_member(where, object, "expires");
    static const std::set<std::string> kKnown{"case",   "gate",   "stage",
                                              "device", "reason", "expires"};
    for (const auto& item : object.items()) {
        if (kKnown.contains(item.key())) continue;
        throw Error::bad_input(where, fmt::format("'{}' is not known here; a waiver has {}",
                                                  item.key(), fmt::join(kKnown, ", ")));
    }
    if (waiver.gate.empty() == waiver.stage.empty()) {
        throw Error::bad_input(where, "expected either 'gate' or 'stage'");
    }
    if (waiver.reason.empty()) throw Error::bad_input(where, "'reason': expected a sentence");
    if (!is_date(waiver.expires)) {
        throw Error::bad_input(
            where,
            fmt::format("'expires': expected a date like 2026-01-31, found '{}'", waiver.expires));
    }
    return waiver;
}

}  // namespace

Date today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))); }

std::string to_string(const Waiver& waiver) {
    return fmt::format("the waiver of {} '{}' for case '{}' on '{}' (reason: {})",
                       waiver.gate.empty() ? "stage" : "gate",
                       waiver.gate.empty() ? waiver.stage : waiver.gate, waiver.golden,
                       waiver.device, waiver.reason);
}

std::vector<Waiver> read_waivers(const std::filesystem::path& golden) {
    const std::filesystem::path file = golden / "waivers.json";
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return {};
    const nlohmann::json document = read_json(file);
    expect_format(file, document, kWaiverFormat, kVersion);
    const std::string place = file.string();
    const nlohmann::json& list = member(place, document, "waivers");
    if (!list.is_array()) throw Error::bad_input(place, "'waivers': expected a list");
    std::vector<Waiver> waivers;
    for (const nlohmann::json& object : list) {
        waivers.push_back(
            parse_waiver(fmt::format("{}: waiver {}", place, waivers.size()), object));
    }
    return waivers;
}

WaiverBook::WaiverBook(std::vector<Waiver> waivers, Date day)
    : waivers_(std::move(waivers)), used_(waivers_.size(), 0), day_(std::move(day)) {}

template <class Matches>
const Waiver* WaiverBook::cover(const std::string& golden, const std::string& device,
                                const Matches& matches) {
    for (std::size_t i = 0; i < waivers_.size(); ++i) {
        const Waiver& waiver = waivers_[i];
        if (waiver.golden != golden || waiver.has_expired(day_)) continue;
        if (waiver.device != kAnyDevice && waiver.device != device) continue;
        if (!matches(waiver)) continue;
        used_[i] = 1;
        return &waiver;
    }
    return nullptr;
}

const Waiver* WaiverBook::cover_gate(const std::string& golden, const std::string& gate,
                                     const std::string& device) {
    return cover(golden, device, [&](const Waiver& waiver) { return waiver.gate == gate; });
}

const Waiver* WaiverBook::cover_stage(const std::string& golden, const std::string& stage,
                                      const std::string& device) {
    return cover(golden, device, [&](const Waiver& waiver) {
        return !waiver.stage.empty() && stage_matches(waiver.stage, stage);
    });
}

std::vector<Waiver> WaiverBook::expired() const {
    std::vector<Waiver> out;
    std::copy_if(waivers_.begin(), waivers_.end(), std::back_inserter(out),
                 [&](const Waiver& waiver) { return waiver.has_expired(day_); });
    return out;
}

std::vector<Waiver> WaiverBook::unused(const std::vector<std::string>& goldens,
                                       const std::string& device) const {
    std::vector<Waiver> out;
    for (std::size_t i = 0; i < waivers_.size(); ++i) {
        const Waiver& waiver = waivers_[i];
        const bool concerned =
            (waiver.device == kAnyDevice || waiver.device == device) &&
            std::find(goldens.begin(), goldens.end(), waiver.golden) != goldens.end();
        if (concerned && used_[i] == 0 && !waiver.has_expired(day_)) out.push_back(waiver);
    }
    return out;
}

}  // namespace scotty::verify
