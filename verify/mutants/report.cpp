/// The score, as text and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "verify/mutants/judge.h"

namespace scotty::verify {

namespace {

std::string launch_text(std::uint32_t launch) {
    return launch == reference::kNotApplicable ? "-" : fmt::format("{}", launch);
}

std::size_t passed_conditions(const MutantReport& report) {
    return static_cast<std::size_t>(
        std::count_if(report.hostile.begin(), report.hostile.end(),
                      [](const HostileResult& result) { return result.failure.empty(); }));
}

std::string row(const MutantResult& result) {
    const MutantCatch& found = result.found;
    std::string text =
        fmt::format("{:<8} {:<30} {:<32} {:<18} {:>6} {:<34} {:>5.1f}  {}\n",
                    result.caught() ? "caught" : "ESCAPED", result.fault.name, result.fault.file,
                    found.check.empty() ? "-" : found.check, launch_text(found.launch),
                    found.stage.empty() ? "-" : found.stage, result.seconds, found.place);
    if (!result.caught()) {
        text += fmt::format("         {}{}{}\n         scotty {} --plant {}\n", result.why_not,
                            found.says.empty() ? "" : "; said: ", found.says, result.fault.run,
                            result.fault.name);
    }
    return text;
}

}  // namespace

std::size_t MutantReport::caught() const {
    return static_cast<std::size_t>(std::count_if(
        faults.begin(), faults.end(), [](const MutantResult& one) { return one.caught(); }));
}

bool MutantReport::passed() const {
    return caught() == faults.size() && passed_conditions(*this) == hostile.size();
}

std::string to_text(const MutantReport& report) {
    std::string text;
    if (!report.faults.empty()) {
        text += fmt::format("{:<8} {:<30} {:<32} {:<18} {:>6} {:<34} {:>5}  {}\n", "verdict",
                            "planted", "in", "found by", "launch", "stage", "s", "place");
    }
    for (const MutantResult& result : report.faults) text += row(result);
    if (!report.hostile.empty()) text += "\nno fault, but hostile\n";
    for (const HostileResult& result : report.hostile) {
        text +=
            fmt::format("{:<8} {:<28} {:>5.1f}  {}\n", result.failure.empty() ? "passed" : "FAILED",
                        result.condition.name, result.seconds, result.condition.what);
        if (!result.failure.empty()) {
            text += fmt::format("         {}\n         scotty {}\n", result.failure,
                                result.condition.run);
        }
    }
    text += "\n";
    if (!report.faults.empty()) {
        text += fmt::format("mutants: {} of {} caught\n", report.caught(), report.faults.size());
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
            {"check", found.check},
            {"stage", found.stage},
            {"launch", nullptr},
            {"place", found.place},
            {"says", found.says},
            {"seconds", result.seconds},
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
                           {"replay", "scotty " + result.condition.run}});
    }
    return {{"passed", report.passed()}, {"caught", report.caught()}, {"of", report.faults.size()},
            {"shard", report.shard},     {"seconds", report.seconds}, {"mutants", mutants},
            {"hostile", hostile}};
}

}  // namespace scotty::verify
