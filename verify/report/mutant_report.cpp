#include "verify/report/mutant_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "reference/base/error.h"
#include "verify/base/shard.h"
#include "verify/report/report_file.h"

namespace scotty::verify {

namespace {

constexpr const char* kMutantsFormat = "cuda-scotty-mutants";

std::string launch_text(std::uint32_t launch) {
    return launch == reference::kNotApplicable ? "-" : fmt::format("{}", launch);
}

std::size_t passed_conditions(const MutantReport& report) {
    return static_cast<std::size_t>(
        std::count_if(report.hostile.begin(), report.hostile.end(),
                      [](const HostileResult& result) { return result.failure.empty(); }));
}

constexpr const char* kRow = "{:<8} {:<30} {:<18} {:>6} {:>6}\n";

std::string row(const MutantResult& result) {
    const MutantCatch& found = result.found;
    std::string text =
        fmt::format(kRow,
                    result.caught()                   ? "caught"
                    : !result.fault.unapplied.empty() ? "GONE"
                                                      : "ESCAPED",
                    result.fault.name, found.check.empty() ? "-" : found.check,
                    launch_text(found.launch), fmt::format("{:.1f}", result.seconds));
    // The place, where it is a line of a kernel, says the file.
    const bool says_file = found.place.starts_with(result.fault.file);
    text += indented(fmt::format("{}{}{}{}{}", says_file ? "" : result.fault.file,
                                 says_file || found.stage.empty() ? "" : ", ", found.stage,
                                 found.place.empty() ? "" : ": ", found.place));
    if (!result.fault.unapplied.empty()) {
        text += indented(result.why_not);
    } else if (!result.caught()) {
        text += indented(result.why_not + (found.says.empty() ? "" : "; said: " + found.says));
        text += fmt::format("         scotty {} --plant {}\n", result.fault.run, result.fault.name);
    }
    return text;
}

}  // namespace

std::string indented(const std::string& text) {
    constexpr std::size_t kColumns = 80;
    const std::string margin(9, ' ');
    std::string out;
    std::string line = margin;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (line.size() > margin.size() && line.size() + 1 + word.size() > kColumns) {
            out += line + "\n";
            line = margin;
        }
        if (line.size() > margin.size()) line += ' ';
        line += word;
    }
    return out + line + "\n";
}

std::size_t MutantReport::caught() const {
    return static_cast<std::size_t>(std::count_if(
        faults.begin(), faults.end(), [](const MutantResult& one) { return one.caught(); }));
}

std::size_t MutantReport::unapplied() const {
    return static_cast<std::size_t>(
        std::count_if(faults.begin(), faults.end(),
                      [](const MutantResult& one) { return !one.fault.unapplied.empty(); }));
}

bool MutantReport::passed() const {
    return caught() == faults.size() && passed_conditions(*this) == hostile.size();
}

std::string to_text(const MutantReport& report) {
    std::string text;
    if (!report.faults.empty()) {
        text += fmt::format(kRow, "verdict", "planted", "found by", "launch", "s");
    }
    for (const MutantResult& result : report.faults) text += row(result);
    if (!report.hostile.empty()) text += "\nno fault, but hostile\n";
    for (const HostileResult& result : report.hostile) {
        text += fmt::format(kRow, result.failure.empty() ? "passed" : "FAILED",
                            result.condition.name, "", "", fmt::format("{:.1f}", result.seconds));
        text += indented(result.condition.what);
        if (!result.failure.empty()) {
            text += indented(result.failure);
            text += fmt::format("         scotty {}\n", result.condition.run);
        }
    }
    return text + "\n" + score(report);
}

std::string score(const MutantReport& report) {
    std::string text;
    if (!report.faults.empty()) {
        text += fmt::format("mutants: {} of {} caught\n", report.caught(), report.faults.size());
    }
    if (report.unapplied() != 0) {
        text += fmt::format(
            "{} of them do not apply any more: verify/mutants/registry.json quotes texts that have "
            "changed\n",
            report.unapplied());
    }
    if (!report.hostile.empty()) {
        text += fmt::format("hostile conditions: {} of {} passed\n", passed_conditions(report),
                            report.hostile.size());
    }
    return text;
}

nlohmann::json to_json(const MutantReport& report) {
    nlohmann::json mutants = nlohmann::json::array();
    for (const MutantResult& result : report.faults) {
        const MutantCatch& found = result.found;
        nlohmann::json one = {
            {"name", result.fault.name},
            {"what", result.fault.what},
            {"file", result.fault.file},
            {"defect", result.fault.defect},
            {"caught", result.caught()},
            {"why_not", result.why_not},
            {"unapplied", result.fault.unapplied},
            {"check", found.check},
            {"stage", found.stage},
            {"launch", nullptr},
            {"place", found.place},
            {"says", found.says},
            {"seconds", result.seconds},
            {"run", result.fault.run},
            {"replay", "scotty " + result.fault.run + " --plant " + result.fault.name}};
        if (found.launch != reference::kNotApplicable) one["launch"] = found.launch;
        mutants.push_back(std::move(one));
    }
    nlohmann::json hostile = nlohmann::json::array();
    for (const HostileResult& result : report.hostile) {
        hostile.push_back({{"name", result.condition.name},
                           {"what", result.condition.what},
                           {"passed", result.failure.empty()},
                           {"failure", result.failure},
                           {"seconds", result.seconds},
                           {"run", result.condition.run},
                           {"replay", "scotty " + result.condition.run}});
    }
    return {{"format", kMutantsFormat},   {"passed", report.passed()}, {"caught", report.caught()},
            {"of", report.faults.size()}, {"shard", report.shard},     {"seconds", report.seconds},
            {"mutants", mutants},         {"hostile", hostile}};
}

bool is_mutant_report(const nlohmann::json& object) {
    return object.is_object() && object.contains("format") && object["format"] == kMutantsFormat;
}

MutantReport read_mutants(const std::string& path, const nlohmann::json& object) {
    try {
        MutantReport report;
        report.shard = object.at("shard");
        report.seconds = object.at("seconds");
        for (const auto& one : object.at("mutants")) {
            MutantResult& result = report.faults.emplace_back();
            result.fault.name = one.at("name");
            result.fault.what = one.at("what");
            result.fault.file = one.at("file");
            result.fault.defect = one.at("defect");
            result.fault.run = one.at("run");
            result.why_not = one.at("why_not");
            result.fault.unapplied = one.value("unapplied", "");
            result.seconds = one.at("seconds");
            result.found.check = one.at("check");
            result.found.stage = one.at("stage");
            result.found.place = one.at("place");
            result.found.says = one.at("says");
            if (!one.at("launch").is_null()) result.found.launch = one.at("launch");
        }
        for (const auto& one : object.at("hostile")) {
            report.hostile.push_back({{one.at("name"), one.at("what"), one.at("run")},
                                      one.at("seconds"),
                                      one.at("failure")});
        }
        return report;
    } catch (const nlohmann::json::exception& error) {
        throw reference::Error::bad_input(path, error.what());
    }
}

MutantReport join(const std::vector<MutantReport>& parts, const std::vector<std::string>& names) {
    std::vector<Shard> shards;
    shards.reserve(parts.size());
    for (const MutantReport& part : parts) shards.push_back(parse_shard(part.shard));
    check_shards(shards, names);
    // Dealt out like cards, faults first and then conditions: so they come back.
    std::map<std::size_t, MutantResult> faults;
    std::map<std::size_t, HostileResult> hostile;
    MutantReport whole;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        std::size_t item = shards[i].index;
        for (const MutantResult& result : parts[i].faults) {
            faults[item] = result;
            item += shards[i].count;
        }
        for (const HostileResult& result : parts[i].hostile) {
            hostile[item] = result;
            item += shards[i].count;
        }
        whole.seconds += parts[i].seconds;
    }
    for (const auto& [item, result] : faults) whole.faults.push_back(result);
    for (const auto& [item, result] : hostile) whole.hostile.push_back(result);
    return whole;
}

}  // namespace scotty::verify
